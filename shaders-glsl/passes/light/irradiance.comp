// Second half of the SH projection. One invocation per coefficient adds the partial sums of the rows in a fixed order, so that results are
// reproducible (LEADR Algorithm 2, with the doubled L00 of its first line corrected). The results are coefficients of radiance, without the
// factors A_l of the cosine lobe.
#version 460
layout(local_size_x = 9) in;

layout(std430) readonly buffer Partials { vec4 partials[]; };
layout(std430) writeonly buffer Harmonics { vec4 harmonics[9]; };
layout(push_constant) uniform Push {
    uint rows; // number of partial sums per coefficient
};

void main()
{
    uint k = gl_LocalInvocationID.x;
    vec3 sum = vec3(0.0);
    vec3 lost = vec3(0.0); // Kahan summation
    for (uint i = 0u; i < rows; ++i) {
        precise vec3 term = partials[k * rows + i].rgb - lost;
        precise vec3 next = sum + term;
        precise vec3 back = next - sum;
        lost = back - term;
        sum = next;
    }
    harmonics[k] = vec4(sum, 0.0);
}
