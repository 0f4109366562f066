// The constants of the atmosphere and its tables. The build turns this file into the module crate::render::light::constants, in 64 bits,
// for crates/leadr-render/src/light/atmosphere.rs and sky.rs. The file may contain only comments and lines of the form `const TYPE NAME =
// VALUE;`. Lengths are in kilometres.
#ifndef ATMOSPHERE_GLSL
#define ATMOSPHERE_GLSL

// The number of rows of the view table. A row has the elevation pi/2 (row/(ROWS-1))^2.
const int ROWS = 64;
// The number of columns of the view table. A column has the azimuth pi column/(COLUMNS-1) from the sun.
const int COLUMNS = 16;
// The number of entries of the multiple scattering table. Entry i has the altitude ATMOSPHERE (i/(ALTITUDES-1))^2.
const int ALTITUDES = 16;

// The radius of the Earth.
const float EARTH = 6360.0;
// The thickness of the atmosphere.
const float ATMOSPHERE = 100.0;
// The scale height of air.
const float AIR_HEIGHT = 8.0;
// The scale height of the aerosol.
const float HAZE_HEIGHT = 1.2;
// The altitude of the ozone peak. The profile is a triangle.
const float OZONE_CENTRE = 25.0;
// Half the width of the ozone triangle.
const float OZONE_HALF_WIDTH = 15.0;
// The scattering of air per km at the ground. The wavelengths 630, 550 and 450 nm represent the Rec.709 primaries. The values follow
// lambda^-4.08, with 0.01356 at 550 nm. The primaries' dominant wavelengths 612, 549 and 465 nm would make the zenith too white. The common
// choice of 680, 550 and 440 nm would make sunlight too orange.
const vec3 AIR = vec3(0.00779, 0.01356, 0.03075);
// The absorption of ozone (Chappuis band) per km at the centre of its layer, at the same wavelengths.
const vec3 OZONE = vec3(0.00190, 0.00188, 0.00014);
// The aerosol extinction relative to 550 nm (Angstrom exponent 1.3).
const vec3 HAZE = vec3(0.838, 1.0, 1.298);
// The single-scattering albedo of the aerosol.
const float HAZE_ALBEDO = 0.92;
// The asymmetry parameter of aerosol scattering.
const float HAZE_ASYMMETRY = 0.76;
// The angular radius of the sun, in radians. The radius determines how fast the sun sets.
const float SUN_RADIUS = 0.00465;
// The width of the haze band in which the ground fades into the horizon, as the sine of an elevation.
const float HORIZON = 0.02;
// The radiance of the sky without a sun, relative to sunlight: airglow, stars and a little moonlight. This radiance is much brighter than a
// real night, so that the scene remains visible.
const vec3 NIGHT = vec3(2.2e-5, 3.2e-5, 5.5e-5);
// Factor on this radiance at the zenith. With the factor at the horizon it keeps the irradiance of level ground.
const float NIGHT_ZENITH = 0.75;
// Factor on the radiance of the night at the horizon.
const float NIGHT_HORIZON = 2.25;
// Irradiance of the moon on a plane that faces it, relative to sunlight: most of the night's light on level ground.
const vec3 MOON = vec3(4.7e-4, 5.0e-4, 5.6e-4);
// Steps along a path to the sun.
const int SUN_STEPS = 24;
// The number of steps along a view ray.
const int VIEW_STEPS = 32;
// The number of directions per axis for multiple scattering.
const int SPHERE_STEPS = 8;

#endif
