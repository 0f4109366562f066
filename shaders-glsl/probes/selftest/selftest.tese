#version 460
layout(quads, equal_spacing) in;
layout(location = 0) out vec2 uv;

void main() {
    vec2 t = gl_TessCoord.xy;
    vec4 top = mix(gl_in[0].gl_Position, gl_in[1].gl_Position, t.x);
    vec4 bottom = mix(gl_in[3].gl_Position, gl_in[2].gl_Position, t.x);
    gl_Position = mix(top, bottom, t.y);
    uv = t;
}
