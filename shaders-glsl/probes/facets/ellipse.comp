#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/ellipse.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 6;
    Ellipse e;
    e.radii = next2();
    e.angle = next();
    vec3 A = next3();
    Bivariate b = bivariate_from_ellipse(e);
    Ellipse back = ellipse_from_bivariate(b);
    Ellipse other = ellipse_from_roughness(A);
    at = gl_GlobalInvocationID.x * 16;
    put(b.alpha);
    put(b.rho);
    put(b.independence);
    put(back.radii);
    put(back.angle);
    put(roughness_from_ellipse(e));
    put(roughness_from_bivariate(b));
    put(other.radii);
    put(other.angle);
}
