// Constants that the shaders and Rust share. The build turns this file into the module crate::render::constants, so it may contain only
// comments and lines of the form `const TYPE NAME = VALUE;`.
#ifndef LEADR_CONSTANTS
#define LEADR_CONSTANTS

// The flags of an object (`ObjectRecordGpu::flags`)

// The object has LEADR maps.
const uint FLAG_DISPLACED = 1u;
// The tangents by texture coordinate are constant. The geometry pass then stores texture coordinates instead of patch parameters.
const uint FLAG_FLAT = 2u;
// Back faces are painted in the marker colour, to test for cracks.
const uint FLAG_MARK_INSIDE = 4u;
// Emission is multiplied by the vertex colours.
const uint FLAG_TINTED_EMISSION = 8u;
// The patches are triangles.
const uint FLAG_TRIANGLES = 16u;
// The material has its own texture coordinates.
const uint FLAG_CHARTED = 32u;
// The opacity is an alpha mask.
const uint FLAG_MASK = 64u;
// Heights are projected along the axes of the rest pose. The patches hold a RestTriangle.
const uint FLAG_TRIPLANAR = 128u;
// Disables tiling by example, so the maps repeat unchanged.
const uint FLAG_ONE_VARIANT = 256u;
// The largest number of measured materials in a scene.
const uint MAX_FITS = 255u;
// The largest number of media behind surfaces in a scene.
const uint MAX_MEDIA = 255u;

// Geometry

// The number of resolutions of the baked heights along an edge: 64, 32, ... 1 segments.
const int EDGE_LEVELS = 7;
// The number of samples of one edge over all levels: 65 + 33 + 17 + 9 + 5 + 3 + 2.
const int EDGE_STRIDE = 134;
// The ratio of the geometry pass's viewport to the image. A scissor rectangle selects the image.
const float GUARD_BAND = 3.0;
// The side of a screen tile in pixels.
const int TILE_SIZE = 16;

// Neighbours beyond the edge of a height map

// The neighbour is the texel at the opposite edge.
const uint MOMENTS_REPEAT = 0u;
// The neighbour is the edge texel itself.
const uint MOMENTS_CLAMP = 1u;
// There is no neighbour, because tiles are independent: differences at the edge of a tile are one-sided.
const uint MOMENTS_ATLAS = 2u;

// What scales and adds to the heights of a map, as bits

// The height scale has a factor per vertex.
const uint HEIGHT_SCALED_BY_VERTEX = 1u;
// The height scale has a map over the texture coordinates.
const uint HEIGHT_SCALED_BY_MAP = 2u;
// The heights of the detail are added.
const uint HEIGHT_WITH_DETAIL = 4u;

// The tiling details on a surface

// There is no tiling detail.
const uint DETAIL_NONE = 0u;
// The detail follows the texture coordinates.
const uint DETAIL_BY_TEXCOORD = 1u;
// The detail follows positions in the rest pose, projected along the axes.
const uint DETAIL_TRIPLANAR = 2u;
// The detail does not change the colours and roughness of the surface.
const uint DETAIL_COLORLESS = 0u;
// The detail modulates the colours of the surface, and replaces its roughness.
const uint DETAIL_VARIES = 1u;
// The detail replaces the colours and the roughness of the surface.
const uint DETAIL_COVERS = 2u;

// The maps that are tiled by example

// The number of lattice edges per repeat of the map.
const float TILING_CELLS = 2.5;

// Tessellation

// The largest tessellation factor. Vulkan allows 64, but fractional odd spacing can only use 63.
const float MAX_FACTOR = 63.0;

// Atlases

// Marks a side of a patch that has no neighbouring patch.
const uint NO_NEIGHBOR = 0xffffffffu;
// The coarsest mip level of the tiles that is read. The coarse levels are computed from this level.
const uint SOURCE_LEVEL = 2u;
// The number of coarse levels in which a texel averages several patches, in squares of up to 8 x 8. Wider squares add more hidden surface
// than they reduce noise, and look worse on the distant T-rex.
const uint WIDE_LEVELS = 3u;

// The number of images of a material that may have texture coordinates of their own. The index of each image follows.

const uint CHARTS = 4u;
// The image of the colours, roughness and reflectance.
const uint CHART_COLORS = 0u;
// The image of the emission.
const uint CHART_EMISSION = 1u;
// The image of the accessibility.
const uint CHART_OCCLUSION = 2u;
// The image of the coverage of an alpha mask.
const uint CHART_OPACITY = 3u;

// Shading

// The largest number of lamps in a frame: point lights, spots, and directional lights beside the sun. Lavapipe leaves all loops of a shader
// after 65,535 iterations. With four classes of facets, a lamp takes up to 50 of them.
const int MAX_LAMPS = 1024;
// The largest number of lamps with shadow maps. They come first in the list of lamps.
const int MAX_LAMP_MAPS = 4;
// The largest number of directional lights extracted from a panorama.
const int MAX_ENVIRONMENT_LIGHTS = 4;
// The largest number of directional lights in a frame: the sun of the frame, and the suns of the panorama.
const int MAX_SUNS = MAX_ENVIRONMENT_LIGHTS + 1;
// The largest number of shadow maps in a frame. The suns are first, and the lamps follow.
const int MAX_SHADOW_MAPS = MAX_SUNS + MAX_LAMP_MAPS;
// The number of directions drawn from the environment per sample of the reference with relief shadows.
const int ENVIRONMENT_DRAWS = 4;
// The largest number of lights of a sample of the reference with relief shadows: lamps, the sun, the suns of the panorama, and the
// directions drawn from the environment.
const int MAX_RELIEF_LIGHTS = MAX_LAMP_MAPS + MAX_SUNS + ENVIRONMENT_DRAWS;
// The largest number of views in a frame. Relief maps need more views than the camera and the shadow maps.
const int MAX_VIEWS = MAX_RELIEF_LIGHTS;
// The smallest Beckmann roughness of a base whose specular environment has relief shadows from depth maps. Smoother materials reflect the
// environment without shadows, because lights drawn from the environment would almost never hit their lobe.
const float MIRROR_ALPHA = 0.15;
// The light belongs to the scene: it is the sun or a lamp.
const int LIGHT_OF_SCENE = 0;
// The light was extracted from the environment.
const int LIGHT_OF_ENVIRONMENT = 1;
// The light was drawn at random from the rest of the environment.
const int LIGHT_DRAWN = 2;

// The volume with the visibility of the sky past large shapes

// The largest number of nodes of the sky visibility volume.
const uint SKY_NODES = 6000u;
// The number of layers of the sky visibility volume, which are denser near the floor, and the number of layers below the floor.
const uint SKY_LAYERS = 12u;
const uint SKY_LAYERS_BELOW = 3u;

// The terms of the light in an image, as bits

// The specular reflection of suns and lamps.
const int TERM_SPECULAR_LIGHTS = 1;
// The diffuse reflection of suns and lamps.
const int TERM_DIFFUSE_LIGHTS = 2;
// The specular reflection of the environment.
const int TERM_SPECULAR_ENVIRONMENT = 4;
// The diffuse reflection of the environment.
const int TERM_DIFFUSE_ENVIRONMENT = 8;

// The meaning of a pixel in the geometry pass

// The pixel is a sample of the image.
const int PIXELS_ARE_SAMPLES = 0;
// The pixel is an edge sample.
const int PIXELS_ARE_EDGES = 1;
// The pixel holds several samples at once by multisampling.
const int PIXELS_ARE_MULTISAMPLED = 2;

// Multisampling

// The side, in pixels, of the blocks whose additional surfaces share one list (passes/msaa.glsl).
const int OTHERS_BLOCK = 8;
// The largest number of additional surfaces in a pixel.
const int MOST_OTHERS = 6;
// The largest number of geometry samples in a pixel.
const uint MOST_MULTISAMPLES = 8u;

// How the shading pass treats edge samples

// There are no edge samples.
const int EDGES_ARE_ABSENT = 0;
// The pass shades all edge samples, except those on their pixel's own surface.
const int EDGES_ARE_SHADED = 1;
// The pass shades pixels whose edge samples are already joined.
const int EDGES_ARE_JOINED = 2;

#endif
