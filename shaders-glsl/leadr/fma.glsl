#ifndef LEADR_FMA_GLSL
#define LEADR_FMA_GLSL

// GLSL before 4.00 and GLSL ES before 3.20 have no fma. The replacement for fma rounds twice. The replacement is a macro, because some
// compilers do not allow a function of this name.
#ifdef GL_ES
#if __VERSION__ < 320 && !defined(fma)
#define fma(a, b, c) ((a) * (b) + (c))
#endif
#elif __VERSION__ < 400 && !defined(fma)
#define fma(a, b, c) ((a) * (b) + (c))
#endif

#endif
