// The atmosphere and its tables. The build turns this file into the module crate::render::light::constants, in 64 bits, for
// crates/leadr-render/src/light/atmosphere.rs and sky.rs. It may contain only comments and lines of the form
// `const TYPE NAME = VALUE;`. Lengths are in kilometres.
#ifndef ATMOSPHERE_GLSL
#define ATMOSPHERE_GLSL

// Rows of the view table: elevation pi/2 (row/(ROWS-1))^2.
const int ROWS = 64;
// Columns of the view table: azimuth from the sun, pi column/(COLUMNS-1).
const int COLUMNS = 16;
// Entries of the multiple scattering table: altitude ATMOSPHERE (i/(ALTITUDES-1))^2.
const int ALTITUDES = 16;

// Radius of the Earth.
const float EARTH = 6360.0;
// Thickness of the atmosphere.
const float ATMOSPHERE = 100.0;
// Scale height of air.
const float AIR_HEIGHT = 8.0;
// Scale height of aerosol.
const float HAZE_HEIGHT = 1.2;
// Altitude of the ozone peak; the profile is a triangle.
const float OZONE_CENTRE = 25.0;
// Half width of the triangle.
const float OZONE_HALF_WIDTH = 15.0;
// Scattering of air per km at the ground at 630, 550 and 450 nm, in place of the Rec.709 primaries: lambda^-4.08 through
// 0.01356 at 550 nm. (The primaries' dominant wavelengths 612, 549, 465 make the zenith too white; 680, 550, 440, often used,
// make sunlight too orange.)
const vec3 AIR = vec3(0.00779, 0.01356, 0.03075);
// Absorption of ozone per km at its centre, at the same wavelengths: the Chappuis band.
const vec3 OZONE = vec3(0.00190, 0.00188, 0.00014);
// Aerosol extinction relative to 550 nm (Angstrom exponent 1.3).
const vec3 HAZE = vec3(0.838, 1.0, 1.298);
// Single-scattering albedo of aerosol.
const float HAZE_ALBEDO = 0.92;
// Asymmetry of aerosol scattering.
const float HAZE_ASYMMETRY = 0.76;
// Angular radius of the sun, radians; sets the speed of a sunset.
const float SUN_RADIUS = 0.00465;
// Width of the haze band in which the ground fades into the horizon, as a sine of elevation.
const float HORIZON = 0.02;
// Radiance of the sky without a sun, relative to sunlight: airglow, stars and a little moon, far brighter than a real night to
// keep the scene visible.
const vec3 NIGHT = vec3(2.2e-5, 3.2e-5, 5.5e-5);
// Factor on this radiance at the zenith. With the factor at the horizon it keeps the irradiance of level ground.
const float NIGHT_ZENITH = 0.75;
// Factor on the radiance of the night at the horizon.
const float NIGHT_HORIZON = 2.25;
// Irradiance of the moon on a plane that faces it, relative to sunlight: most of the night's light on level ground.
const vec3 MOON = vec3(6.5e-4, 7.0e-4, 7.8e-4);
// Steps along a path to the sun.
const int SUN_STEPS = 24;
// Steps along a view ray.
const int VIEW_STEPS = 32;
// Directions per axis of the multiple scattering.
const int SPHERE_STEPS = 8;

#endif
