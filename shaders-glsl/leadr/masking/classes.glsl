#ifndef LEADR_CLASS_MASKING_GLSL
#define LEADR_CLASS_MASKING_GLSL

#include "../facets/projected_area.glsl"
#include "../slopes/grid.glsl"
#include "correlated.glsl"

// Computes masking and shadowing of a relief whose facets form classes, such as tops, walls and bottoms. High classes hide low ones.
// crates/leadr-reflectance/src/masking/classes.rs derives the form. Once per pixel:
//     ClassHiding hiding = class_hiding(count, share, m, S, height);
//     ClassDepths o = class_depths(hiding, wo);
//     vec4 seen = visible_shares(o);
// and for each light:
//     vec4 lit = class_lit_fractions(shadowing, o, class_depths(hiding, wi));
// A constant count lets the compiler remove the loops over absent classes. Absent classes have the share 0 in all results.

const int LEADR_MOST_CLASSES = 4;

// The classes of a footprint, and how they hide each other, independent of the direction.
struct ClassHiding {
    int count;      // 1..4
    vec4 share;     // fraction of the mesosurface; sums to one
    vec2 m[4];      // mean slopes
    vec3 S[4];      // slope covariances
    vec2 mean;      // mean slope of all facets
    vec3 cholesky;  // of the slope covariance of all facets
    mat4 above;     // above[j][k]: mean optical depth of class j above the facets of class k, per unit of its blocking area
    vec4 bend;      // 0..1/2: 0 for depths that are spread as Smith's, 1/2 for facets of one depth
};

// What the classes hide from one direction.
struct ClassDepths {
    vec4 area;     // share times visible area, without hiding by other facets
    vec4 depth;    // optical depth above the facets of each class
    vec4 bend;     // ClassHiding.bend
    float lambda;  // Lambda of all classes
    vec2 whitened; // the direction in the space with isotropic slopes
    float meso;    // projected area of the mesosurface; negative if it faces away
};

// Relates the classes. height has the mean and the variance of the heights of each class, in any unit.
ClassHiding class_hiding(const int count, const vec4 share, const vec2 m[4], const vec3 S[4], const vec2 height[4]) {
    const float node = 0.801832716;        // two heights represent those of a class: the quantiles 1/2 -+ 1/sqrt(12)
    const float per_variance = 2.05887328; // so that v = 1 for one class
    ClassHiding h;
    h.count = count;
    h.m = m;
    h.S = S;
    h.share = vec4(0.0);
    vec4 mean_height = vec4(0.0);
    vec4 spread = vec4(1.0);
    for (int k = 0; k < LEADR_MOST_CLASSES; ++k) {
        if (k >= count) break;
        h.share[k] = share[k];
        mean_height[k] = height[k].x;
        spread[k] = max(height[k].y, 1e-12);
    }
    h.share /= max(h.share.x + h.share.y + h.share.z + h.share.w, 1e-30);
    h.mean = vec2(0.0);
    vec3 square = vec3(0.0);
    h.above = mat4(0.0);
    h.bend = vec4(0.0);
    for (int j = 0; j < LEADR_MOST_CLASSES; ++j) {
        if (j >= count) break;
        h.mean += h.share[j] * m[j];
        square += h.share[j] * (S[j] + vec3(m[j] * m[j], m[j].x * m[j].y));
        vec4 off = mean_height[j] - mean_height;
        float half_spread = node * sqrt(spread[j]);
        // The fraction of each class below the two heights: a distribution near the normal one, without an exponential.
        vec4 low = off - half_spread;
        vec4 high = off + half_spread;
        low = 0.5 + 0.5 * low * inversesqrt(low * low + 1.57079633 * spread);
        high = 0.5 + 0.5 * high * inversesqrt(high * high + 1.57079633 * spread);
        float all_low = clamp(dot(h.share, low), 1e-30, 1.0);
        float all_high = clamp(dot(h.share, high), 1e-30, 1.0);
        h.above[j] = (0.5 * h.share[j]) * (low / all_low + high / all_high);
        float depth_low = -log(all_low);
        float depth_high = -log(all_high);
        float ratio = (depth_low - depth_high) / max(depth_low + depth_high, 1e-12);
        h.bend[j] = 0.5 - 0.5 * min(ratio * ratio * per_variance, 1.0);
    }
    h.cholesky = slope_cholesky(square - vec3(h.mean * h.mean, h.mean.x * h.mean.y));
    return h;
}

// Returns the areas and optical depths of the classes from the direction w.
ClassDepths class_depths(const ClassHiding h, const vec3 w) {
    ClassDepths d;
    d.meso = meso_area(w, h.mean);
    d.whitened = whitened_direction(w, h.cholesky);
    d.bend = h.bend;
    d.area = vec4(0.0);
    d.depth = vec4(0.0);
    d.lambda = 0.0;
    float per_meso = 1.0 / max(d.meso, LEADR_MIN_AREA);
    for (int k = 0; k < LEADR_MOST_CLASSES; ++k) {
        if (k >= h.count) break;
        float a = meso_area(w, h.m[k]);
        float rough = rough_area(a, slope_spread(w, h.S[k]));
        float blocking = (max(-a, 0.0) + rough) * per_meso;
        d.area[k] = h.share[k] * (max(a, 0.0) + rough);
        d.depth += h.above[k] * blocking;
        d.lambda += h.share[k] * blocking;
    }
    // The depths are scaled by a factor near 1, so that the visible areas nearly sum to the projected area of the mesosurface.
    vec4 more = d.depth + d.bend * d.depth * d.depth;
    vec4 open = d.area / (1.0 + more);
    d.depth *= (d.lambda * dot(open, vec4(1.0)) + 1e-20) / (dot(open, more) + 1e-20);
    return d;
}

// Returns the fraction of the facets of each class that is open at these optical depths.
vec4 class_open(const vec4 bend, const vec4 depth) {
    return 1.0 / (1.0 + depth + bend * depth * depth);
}

// Returns the share of each class in the area that is visible. The shares sum to one.
vec4 visible_shares(const ClassDepths o) {
    vec4 area = o.area * class_open(o.bend, o.depth);
    return area / max(dot(area, vec4(1.0)), 1e-30);
}

// Returns the fraction of the facets of each class that is lit from the direction of i, among those that are visible from o. The fraction
// of one class is lit_fraction.
vec4 class_lit_fractions(const int shadowing, const ClassDepths o, const ClassDepths i) {
    if (shadowing == LEADR_SHADOWING_NONE || shadowing == LEADR_SHADOWING_NORMAL_MAP) return vec4(1.0);
    if (i.meso <= 0.0) return vec4(0.0);
    float f = 1.0;
    if (shadowing != LEADR_SHADOWING_SMITH)
        f = decorrelation(o.whitened, i.whitened, 1.0, max(o.lambda, i.lambda), min(o.lambda, i.lambda),
                          shadowing == LEADR_SHADOWING_CORRELATED_SIMPLE);
    vec4 both = max(o.depth, i.depth) + f * min(o.depth, i.depth);
    return (1.0 + o.depth + o.bend * o.depth * o.depth) / (1.0 + both + o.bend * both * both);
}

#endif
