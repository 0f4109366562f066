#ifndef LEADR_NORMAL_DISTRIBUTION_GLSL
#define LEADR_NORMAL_DISTRIBUTION_GLSL

// The standard normal distribution, one exponential and one division each.
// The rational parts are minimax fits of this project (relative error 3e-7 and 4e-7 over 0..14, all coefficients
// positive, so nothing cancels); beyond 13 the density underflows in 32 bits and the argument is held there.

// phi(x), the density.
float normal_pdf(float x) {
    float t = clamp(x, -13.0, 13.0);
    return 0.3989422804 * exp(-0.5 * t * t);
}

// E[max(0, u - x)] = phi(x) - x (1 - Phi(x)) for u ~ N(0,1) and x >= 0: what the tail above x adds to a clamped mean.
float normal_tail_mean(float x) {
    float t = clamp(x, 0.0, 13.0);
    float p = 1.0 + t * (0.55532703 + t * (0.15290028 + t * 0.01936395));
    float q = 1.0 + t * (1.80865213 + t * (1.41958115 + t * (0.61708401 + t * (0.1527089 + t * 0.01936814))));
    return normal_pdf(t) * p / q;
}

// Phi(x), the cumulative distribution, by Mills' ratio.
float normal_cdf(float x) {
    float t = min(abs(x), 13.0);
    float p = 1.25331414 + t * (0.90476948 + t * (0.2980476 + t * 0.04231701));
    float q = 1.0 + t * (1.51977327 + t * (0.95053471 + t * (0.29783986 + t * 0.04232216)));
    float tail = normal_pdf(t) * p / q;
    return x < 0.0 ? tail : 1.0 - tail;
}

#endif
