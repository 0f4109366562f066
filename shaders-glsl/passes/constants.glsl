// Constants shared by the shaders and Rust. The build turns this file into the module crate::render::constants, so it may
// contain only comments and lines of the form `const TYPE NAME = VALUE;`.
#ifndef LEADR_CONSTANTS
#define LEADR_CONSTANTS

// Flags of an object (`ObjectRecordGpu::flags`)

// The object has LEADR maps.
const uint FLAG_DISPLACED = 1u;
// Tangents by texture coordinate are constant: the geometry pass stores texture coordinates, not patch parameters.
const uint FLAG_FLAT = 2u;
// Back faces are painted in the marker colour (crack test).
const uint FLAG_MARK_INSIDE = 4u;
// Emission is multiplied by the vertex colours.
const uint FLAG_TINTED_EMISSION = 8u;
// The patches are triangles.
const uint FLAG_TRIANGLES = 16u;
// The material has its own texture coordinates.
const uint FLAG_CHARTED = 32u;
// The opacity is an alpha mask.
const uint FLAG_MASK = 64u;
// Heights are projected along the axes of the rest pose: the patches hold a RestTriangle.
const uint FLAG_TRIPLANAR = 128u;
// Disables tiling without repeats: maps are shown as they are.
const uint FLAG_ONE_VARIANT = 256u;
// Largest number of measured materials in a scene.
const uint MAX_FITS = 255u;

// Geometry

// Resolutions of the baked heights along an edge: 64, 32, ... 1 segments.
const int EDGE_LEVELS = 7;
// Samples of one edge over all levels: 65 + 33 + 17 + 9 + 5 + 3 + 2.
const int EDGE_STRIDE = 134;
// Ratio of the geometry pass's viewport to the image. The scissor selects the image.
const float GUARD_BAND = 3.0;
// Side of a screen tile in pixels.
const int TILE_SIZE = 16;

// Neighbours of the edge texels of a height map

// The texel at the opposite edge.
const uint MOMENTS_REPEAT = 0u;
// The edge texel itself.
const uint MOMENTS_CLAMP = 1u;
// Independent tiles: differences at the edge of a tile are one-sided.
const uint MOMENTS_ATLAS = 2u;

// Tiling details on a surface

// Coordinates of a detail: none,
const uint DETAIL_NONE = 0u;
// texture coordinates,
const uint DETAIL_BY_TEXCOORD = 1u;
// or positions at rest, projected along the axes.
const uint DETAIL_TRIPLANAR = 2u;
// Effect of its colours and roughness: none,
const uint DETAIL_COLORLESS = 0u;
// they modulate the colours of the surface and replace its roughness,
const uint DETAIL_VARIES = 1u;
// or they replace both.
const uint DETAIL_COVERS = 2u;

// Maps tiled without visible repeats

// Edges of the lattice per repeat of the map.
const float TILING_CELLS = 2.5;

// Atlases

// Marks a side without a neighbouring patch.
const uint NO_NEIGHBOR = 0xffffffffu;
// The coarsest mip level of the tiles in use; the coarse levels are made from it.
const uint SOURCE_LEVEL = 2u;
// Coarse levels of patch corners that average several patches: squares of up to 8. Wider ones add more hidden surface than they
// reduce noise, and look worse on the distant T-rex.
const uint WIDE_LEVELS = 3u;

// Images of a material that may have their own texture coordinates: their number, and the index of each

const uint CHARTS = 4u;
// Colours, roughness and reflectance.
const uint CHART_COLORS = 0u;
// Emission.
const uint CHART_EMISSION = 1u;
// Accessibility.
const uint CHART_OCCLUSION = 2u;
// Coverage of alpha masks.
const uint CHART_OPACITY = 3u;

// Shading

// Largest number of point lights in a frame.
const int MAX_POINT_LIGHTS = 4;
// Largest number of directional lights extracted from a panorama.
const int MAX_ENVIRONMENT_LIGHTS = 4;
// Largest number of directional lights in a frame: its own sun, and those of the panorama.
const int MAX_SUNS = MAX_ENVIRONMENT_LIGHTS + 1;
// Largest number of shadow maps in a frame: one per light, suns first.
const int MAX_SHADOW_MAPS = MAX_SUNS + MAX_POINT_LIGHTS;
// Directions drawn from the environment per sample of the reference with relief shadows.
const int ENVIRONMENT_DRAWS = 4;
// Largest number of lights of such a sample: point lights, the sun, those of the panorama, those drawn from the environment.
const int MAX_RELIEF_LIGHTS = MAX_POINT_LIGHTS + MAX_SUNS + ENVIRONMENT_DRAWS;
// Largest number of views in a frame: relief maps need more than the camera and its shadow maps.
const int MAX_VIEWS = MAX_RELIEF_LIGHTS;
// Beckmann roughness from which relief shadows from depth maps apply to a base's specular environment. Smoother materials
// reflect the environment unshadowed: lights drawn from it would almost never hit their lobe.
const float MIRROR_ALPHA = 0.15;
// Lights of a sample of the reference: the sun or a point light,
const int LIGHT_OF_SCENE = 0;
// one extracted from the environment,
const int LIGHT_OF_ENVIRONMENT = 1;
// one drawn at random from the rest of it.
const int LIGHT_DRAWN = 2;

// Visibility of the sky past large shapes

// Largest number of nodes of its volume.
const uint SKY_NODES = 6000u;
// Its layers, denser near the floor, and the number below the floor.
const uint SKY_LAYERS = 12u;
const uint SKY_LAYERS_BELOW = 3u;

// Terms of the light in an image, as bits

// Specular reflection of sun and point lights.
const int TERM_SPECULAR_LIGHTS = 1;
// Diffuse reflection of sun and point lights.
const int TERM_DIFFUSE_LIGHTS = 2;
// Specular reflection of the environment.
const int TERM_SPECULAR_ENVIRONMENT = 4;
// Diffuse reflection of the environment.
const int TERM_DIFFUSE_ENVIRONMENT = 8;

// Meaning of a pixel of the geometry pass

// A sample of the image.
const int PIXELS_ARE_SAMPLES = 0;
// An edge sample.
const int PIXELS_ARE_EDGES = 1;
// Several samples at once, multisampled.
const int PIXELS_ARE_MULTISAMPLED = 2;

// Multisampling

// Side of the pixel blocks whose other surfaces share a list (passes/msaa.glsl).
const int OTHERS_BLOCK = 8;
// Largest number of additional surfaces in a pixel.
const int MOST_OTHERS = 6;
// Largest number of geometry samples in a pixel.
const uint MOST_MULTISAMPLES = 8u;

// Edge samples in the shading pass

// None.
const int EDGES_ARE_ABSENT = 0;
// Shades them, except those on their pixel's own surface.
const int EDGES_ARE_SHADED = 1;
// Shades pixels whose edge samples were joined before.
const int EDGES_ARE_JOINED = 2;

#endif
