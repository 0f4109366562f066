//! Layers of the last sample, which can be read back.

use glam::{Vec2, Vec3, Vec4};
use serde::{Serialize, Serializer};

use super::drawing::Purpose;
use super::renderer::{LastSample, Renderer};
use super::timing::CpuTime;
use crate::passes::targets::FilteredPixel;
use leadr_gpu::Result;
use leadr_reflectance::facets::projected_area::visible_area;
use leadr_reflectance::frame::{frame_about, to_frame};

/// A quantity in every pixel of the last sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// The distance along the view axis in metres, which is infinite in empty pixels.
    Depth,
    /// The displacement direction in world space, which is the z axis of the tangent frame.
    Normal,
    /// The mean slope in the tangent frame.
    MeanSlope,
    /// The slope covariance `sxx, syy, sxy`.
    Covariance,
    /// The level of detail at which the maps are read.
    Lod,
    /// The linear albedo.
    Albedo,
    /// The Beckmann roughness of the base material.
    Roughness,
    /// The projected area of the bumps that face the viewer, relative to the projected area of the macrosurface: `A(ωo) / cos θ`
    /// (LEADR section 4.3).
    VisibleArea,
    /// The object number (counted from 1, with the sea last), the patch number, and the position on the patch. All are 0 in empty
    /// pixels.
    Patch,
    /// The fraction of the light of suns and lamps that relief and casters leave unshadowed, from 0 (in shadow) to 1 (lit). Empty
    /// pixels have 1. The reference, too, takes this layer from shadow maps.
    Shadow,
    /// The cosine-weighted fraction of the environment that large shapes leave visible. The fraction is 1 in empty pixels and
    /// without sky occlusion.
    Sky,
    /// The triangle edges. The value is 1 on an edge and 0 elsewhere.
    Triangles,
    /// The number of patch segments along u and v, from 1 to 63. The number is 0 in empty pixels and on a ray-marched sea.
    Tessellation,
}

/// The description of a layer.
struct Row {
    name: &'static str,
    help: &'static str,
    channels: &'static [&'static str],
}

impl Layer {
    /// The list of all layers.
    pub const ALL: [Self; 13] = [
        Self::Depth,
        Self::Normal,
        Self::MeanSlope,
        Self::Covariance,
        Self::Lod,
        Self::Albedo,
        Self::Roughness,
        Self::VisibleArea,
        Self::Patch,
        Self::Shadow,
        Self::Sky,
        Self::Triangles,
        Self::Tessellation,
    ];

    fn row(self) -> Row {
        let row = |name, help, channels| Row { name, help, channels };
        match self {
            Self::Depth => row("depth", "Distance along the view axis, metres", &["depth.Z"]),
            Self::Normal => row("normal", "World-space displacement direction", &["normal.X", "normal.Y", "normal.Z"]),
            Self::MeanSlope => row("mean-slope", "Mean slope in the tangent frame", &["mean_slope.X", "mean_slope.Y"]),
            Self::Covariance => {
                row("covariance", "Slope covariance: xx, yy, xy", &["covariance.XX", "covariance.YY", "covariance.XY"])
            }
            Self::Lod => row("lod", "Level of detail of the displacement map", &["lod.L"]),
            Self::Albedo => row("albedo", "Linear albedo", &["albedo.R", "albedo.G", "albedo.B"]),
            Self::Roughness => row("roughness", "Beckmann roughness of the base material", &["roughness.A"]),
            Self::VisibleArea => {
                row("visible-area", "Visible area of the bumps, relative to the smooth surface", &["visible_area.A"])
            }
            Self::Patch => row(
                "patch",
                "Object (from 1), patch, and position on it",
                &["patch.object", "patch.index", "patch.u", "patch.v"],
            ),
            Self::Shadow => row("shadow", "Unshadowed fraction of the light of suns and lamps", &["shadow.L"]),
            Self::Sky => row("sky", "Fraction of the environment that large shapes leave visible", &["sky.L"]),
            Self::Triangles => row("triangles", "1 on triangle edges", &["triangles.edge"]),
            Self::Tessellation => {
                row("tessellation", "Segments of the patch along u and v", &["tessellation.u", "tessellation.v"])
            }
        }
    }

    /// Returns the layer's name on the command line.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Returns one line of help.
    pub fn help(self) -> &'static str {
        self.row().help
    }

    /// Returns the channel names of the layer in an EXR file, in order.
    pub fn channels(self) -> &'static [&'static str] {
        self.row().channels
    }
}

impl Serialize for Layer {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Renderer {
    /// Reads a layer of the last sample. Unused channels are 0, and the result is empty before the first sample. Layers that
    /// neither the geometry nor the G-buffer contains are drawn again, and a paused frame can then no longer be resumed.
    ///
    /// # Errors
    /// Returns the errors of [`prepare`](Self::prepare), and [`GpuError::Usage`](leadr_gpu::GpuError) for triangle edges on a
    /// device that cannot draw lines.
    pub fn layer(&mut self, layer: Layer) -> Result<Vec<[f32; 4]>> {
        let Some((camera, settings)) = self.last.as_ref().map(|last| (last.state.camera, last.settings)) else {
            return Ok(Vec::new());
        };
        match layer {
            Layer::Shadow => {
                return Ok(self.light_shares()?.iter().map(|&[light, _]| [light, 0.0, 0.0, 0.0]).collect());
            }
            Layer::Sky => return Ok(self.light_shares()?.iter().map(|&[_, sky]| [sky, 0.0, 0.0, 0.0]).collect()),
            Layer::Triangles => return self.wires(),
            Layer::Tessellation => return self.segments(),
            _ => {}
        }
        if !matches!(layer, Layer::Depth | Layer::Patch) || settings.msaa > 1 {
            self.fill_gbuffer()?;
        }
        let Some(targets) = &self.targets else { return Ok(Vec::new()) };
        let channels: fn(&FilteredPixel) -> Vec4 = match layer {
            Layer::Depth => {
                let depth: Vec<f32> = targets.pixels.visible.depth.read(0, 0)?;
                let distance = |z: f32| if z > 0.0 { camera.near / z } else { f32::INFINITY };
                return Ok(depth.iter().map(|&z| [distance(z), 0.0, 0.0, 0.0]).collect());
            }
            Layer::Normal => |pixel| pixel.normal.as_vec3().extend(0.0),
            Layer::MeanSlope => |pixel| pixel.mean_slope.extend(0.0).extend(0.0),
            Layer::Covariance => |pixel| pixel.slope_covariance.extend(0.0),
            Layer::Lod => |pixel| Vec4::X * pixel.lod,
            Layer::Albedo => |pixel| pixel.albedo.extend(0.0),
            Layer::Roughness => |pixel| Vec4::X * pixel.roughness,
            Layer::VisibleArea => {
                let depth: Vec<f32> = targets.pixels.visible.depth.read(0, 0)?;
                let (size, [across, down, middle]) = (settings.size, camera.rays(settings.size, Vec2::ZERO));
                let towards_eye = |x: u32, y: u32| {
                    let position = |i: u32, count: u32| 2.0 * (i as f32 + 0.5) / count as f32 - 1.0;
                    -(middle + across * position(x, size.0) + down * position(y, size.1)).normalize()
                };
                let pixels = targets.pixels.gbuffer.read()?;
                let areas = pixels.iter().zip(&depth).zip(0..).map(|((pixel, &depth), i)| {
                    let seen =
                        if depth > 0.0 { visible_share(pixel, towards_eye(i % size.0, i / size.0)) } else { 0.0 };
                    [seen, 0.0, 0.0, 0.0]
                });
                return Ok(areas.collect());
            }
            Layer::Patch => {
                let numbering = self.numbering;
                let surface: Vec<[u32; 4]> = targets.pixels.visible.surface.read(0, 0)?;
                let patch = |&[word, u, v, _]: &[u32; 4]| {
                    let [object, index] = numbering.parts(word);
                    let position = [u, v]
                        .map(|bits| Some(f32::from_bits(bits)).filter(|v| object > 0 && v.is_finite()).unwrap_or(0.0));
                    [object as f32, index as f32, position[0], position[1]]
                };
                return Ok(surface.iter().map(patch).collect());
            }
            // These layers were returned above.
            Layer::Shadow | Layer::Sky | Layer::Triangles | Layer::Tessellation => |_| Vec4::ZERO,
        };
        Ok(targets.pixels.gbuffer.read()?.iter().map(|pixel| channels(pixel).to_array()).collect())
    }

    /// Fills the G-buffer from the last sample, if the sample was shaded without a G-buffer.
    fn fill_gbuffer(&mut self) -> Result<()> {
        let Some(last) = self.last.clone().filter(|last| !last.in_gbuffer) else { return Ok(()) };
        let timer = self.timer.clone();
        let mut frame = self.prepare_for(&last.state, &last.settings, Purpose::GBuffer)?;
        let pixels = frame.plan.pixels(last.index);
        frame.set_view(&pixels, last.index)?;
        timer.submit(&mut CpuTime::default(), |passes| {
            frame.plan.surfaces.record_motion(passes);
            frame.record_pixel_geometry(passes, &pixels);
            frame.record_filter(passes, &frame.plan.targets.pixels, &pixels, None);
        })?;
        let settings = frame.plan.settings;
        self.last = Some(LastSample { in_gbuffer: true, settings, ..last });
        Ok(())
    }
}

/// The smallest cosine of the view angle. Smaller cosines are clamped to it.
const LEAST_COSINE: f64 = 1e-2;

/// Returns the projected area of the bumps that face the eye, relative to the projected area of the surface.
fn visible_share(pixel: &FilteredPixel, towards_eye: Vec3) -> f32 {
    let wo = to_frame(&frame_about(pixel.normal), towards_eye.as_dvec3());
    let area = visible_area(wo, pixel.mean_slope.as_dvec2(), pixel.slope_covariance.as_dvec3());
    (area / wo.z.max(LEAST_COSINE)) as f32
}
