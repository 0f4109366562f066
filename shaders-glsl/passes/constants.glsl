// Constants that the shaders share with Rust. Each stands here alone: the build turns this file into the module
// crate::render::constants, so it holds nothing but comments and lines of the form `const TYPE NAME = VALUE;`.
#ifndef LEADR_CONSTANTS
#define LEADR_CONSTANTS

// Flags of an object (`ObjectGpu::flags`)

// It has LEADR maps.
const uint FLAG_DISPLACED = 1u;
// Its tangents by texture coordinate are the same everywhere: the geometry pass stores texture coordinates, not places on patches.
const uint FLAG_FLAT = 2u;
// Back faces are painted in the marker colour (crack test).
const uint FLAG_MARK_INSIDE = 4u;
// What it emits is multiplied with the colours of its vertices.
const uint FLAG_TINTED_EMISSION = 8u;
// Its patches are triangles.
const uint FLAG_TRIANGLES = 16u;
// Its material has texture coordinates of its own.
const uint FLAG_CHARTED = 32u;
// Its opacity is a mask.
const uint FLAG_MASK = 64u;
// Its heights are seen along the axes where it is at rest: its patches hold a RestTriangle.
const uint FLAG_TRIPLANAR = 128u;
// What could be shown without repeats is shown as it is.
const uint FLAG_ONE_LOOK = 256u;
// Most measured materials of a scene.
const uint MAX_FITS = 255u;

// Geometry

// Resolutions of the baked heights along an edge: 64, 32, ... 1 segments.
const int EDGE_LEVELS = 7;
// Samples of one edge over all levels: 65 + 33 + 17 + 9 + 5 + 3 + 2.
const int EDGE_STRIDE = 134;
// The geometry pass draws into a viewport this many times as large as the image, of which the scissor leaves the image.
const float GUARD_BAND = 3.0;
// Side of a screen tile in pixels.
const int TILE_SIZE = 16;

// What lies beyond the edges of a height map

// Its other side.
const uint MOMENTS_REPEAT = 0u;
// Its edge texel again.
const uint MOMENTS_CLAMP = 1u;
// Tiles that know nothing of each other: differences at the edge of a tile are one-sided.
const uint MOMENTS_ATLAS = 2u;

// Tiling details on a surface

// What coordinates one follows: there is none,
const uint DETAIL_NONE = 0u;
// texture coordinates,
const uint DETAIL_BY_TEXCOORD = 1u;
// or places of the surface at rest, seen along the axes.
const uint DETAIL_TRIPLANAR = 2u;
// What its colours and roughness do: it has none,
const uint DETAIL_COLORLESS = 0u;
// they vary the colours of the surface and replace its roughness,
const uint DETAIL_VARIES = 1u;
// or they replace both.
const uint DETAIL_COVERS = 2u;

// Maps shown without their repeats

// Edges of the lattice along a repeat of the map.
const float TILING_CELLS = 2.5;

// Atlases

// Says that there is no patch beyond a side.
const uint NO_NEIGHBOR = 0xffffffffu;
// The last level of the tiles' mips that is used; from it the coarse levels are made.
const uint SOURCE_LEVEL = 2u;
// Coarse levels of patch corners alone, which reach over more than one patch: squares of up to 8. Wider ones bring in more
// of what is hidden than they calm: the far T-rex becomes worse.
const uint WIDE_LEVELS = 3u;

// Images of a material that may have texture coordinates of their own: their number, and each one's own

const uint CHARTS = 4u;
// Colours, roughness and reflectance.
const uint CHART_COLORS = 0u;
// Emission.
const uint CHART_EMISSION = 1u;
// Accessibility.
const uint CHART_OCCLUSION = 2u;
// Coverage of what has holes.
const uint CHART_OPACITY = 3u;

// Shading

// Most point lights of a frame.
const int MAX_POINT_LIGHTS = 4;
// Most directional lights that are taken out of a panorama.
const int MAX_ENVIRONMENT_LIGHTS = 4;
// Most directional lights of a frame: its own sun, and those of the panorama.
const int MAX_SUNS = MAX_ENVIRONMENT_LIGHTS + 1;
// Most shadow maps of a frame: one of every light, suns first.
const int MAX_SHADOW_MAPS = MAX_SUNS + MAX_POINT_LIGHTS;
// Directions that a sample of the reference with shadows of the relief draws from the environment.
const int ENVIRONMENT_DRAWS = 4;
// Most lights of such a sample: point lights, the sun, those of the panorama, those drawn from the environment.
const int MAX_RELIEF_LIGHTS = MAX_POINT_LIGHTS + MAX_SUNS + ENVIRONMENT_DRAWS;
// Most views of a frame: its maps of relief are more than the camera and its shadow maps.
const int MAX_VIEWS = MAX_RELIEF_LIGHTS;
// Beckmann roughness from which on a base material's specular environment has shadows of the relief where these come from depth maps.
// Smoother materials mirror the environment as if nothing shadowed it: lights drawn from it would almost never meet their lobe.
const float MIRROR_ALPHA = 0.15;
// Lights of a sample of the reference: the sun or a point light,
const int LIGHT_OF_SCENE = 0;
// one that was taken out of the environment,
const int LIGHT_OF_ENVIRONMENT = 1;
// one drawn at random from the rest of it.
const int LIGHT_DRAWN = 2;

// Visibility of the sky past large shapes

// Most nodes of its volume.
const uint SKY_NODES = 6000u;
// Its layers, the denser the nearer to the floor, and how many of them lie below that.
const uint SKY_LAYERS = 12u;
const uint SKY_LAYERS_BELOW = 3u;

// Terms of the light that a picture contains, as bits

// Sun and point lights in mirrors.
const int TERM_SPECULAR_LIGHTS = 1;
// Sun and point lights on the diffuse surface.
const int TERM_DIFFUSE_LIGHTS = 2;
// The environment in mirrors.
const int TERM_SPECULAR_ENVIRONMENT = 4;
// The environment on the diffuse surface.
const int TERM_DIFFUSE_ENVIRONMENT = 8;

// What a pixel of the geometry pass is

// A sample of the picture.
const int PIXELS_ARE_SAMPLES = 0;
// An edge sample.
const int PIXELS_ARE_EDGES = 1;
// Several samples at once, multisampled.
const int PIXELS_ARE_MULTISAMPLED = 2;

// Multisampling

// Side of the blocks of pixels whose other surfaces are listed together (passes/msaa.glsl).
const int OTHERS_BLOCK = 8;
// Surfaces beside its own that a pixel can have.
const int MOST_OTHERS = 6;
// Most samples of the geometry in a pixel.
const uint MOST_MULTISAMPLES = 8u;

// What the shading pass has to do with edge samples

// There are none.
const int EDGES_ARE_ABSENT = 0;
// It shades them, but for those that see their pixel's own surface.
const int EDGES_ARE_SHADED = 1;
// It shades pixels whose edge samples were joined before.
const int EDGES_ARE_JOINED = 2;

#endif
