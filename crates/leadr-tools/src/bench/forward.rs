//! A plain forward pass over the quad of the paper's tables. The pass measures the cost of the paper's fragment shaders
//! without the renderer.
//!
//! The forward pass is one render pass. Each technique has a fragment shader from the supplement (section 3), which fetches
//! each LEADR map once with trilinear filtering. The pass has no G-buffer, tiles or edge samples.

use std::fmt;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use leadr_gpu::{
    AddressMode, Buffer, ColorTarget, Commands, Descriptor, Filter, Gpu, GpuError, GraphicsDesc, GraphicsPipeline,
    Image, ImageDesc, ImageView, Load, Memory, Result, Sampler, SharedStruct, SpecValue, StructLayout, Timestamps, Use,
    shared_struct,
};
use leadr_render::frame::PassTime;
use leadr_render::passes::targets::RADIANCE_FORMAT;
use leadr_render::scene::{FrameState, Object};
use leadr_render::surfaces::displacement::Border;
use leadr_render::surfaces::moments::{LeadrMapGpu, MomentFormat};

/// The name of the pass.
pub const FORWARD: &str = "forward";

/// The shading of the forward pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Forward {
    /// The albedo without light.
    Constant,
    /// One light with a Blinn-Phong lobe about the mean normal.
    BlinnPhong,
    /// One light with LEAN mapping.
    Lean,
    /// One light with LEADR mapping, with masking but without shadowing.
    Leadr,
    /// The specular environment, sampled on a grid with this many slopes along a side (simplified Algorithm 1).
    Environment(u32),
    /// The diffuse environment, sampled on a grid with this many slopes along a side (simplified Algorithm 3).
    Irradiance(u32),
}

impl Forward {
    /// All variants that are measured.
    pub const ALL: [Self; 9] = [
        Self::Constant,
        Self::BlinnPhong,
        Self::Lean,
        Self::Leadr,
        Self::Environment(1),
        Self::Environment(3),
        Self::Environment(4),
        Self::Environment(5),
        Self::Irradiance(5),
    ];

    fn shader(self) -> &'static str {
        match self {
            Self::Constant => "passes/forward/constant.frag",
            Self::BlinnPhong => "passes/forward/blinn_phong.frag",
            Self::Lean => "passes/forward/lean.frag",
            Self::Leadr => "passes/forward/leadr.frag",
            Self::Environment(_) => "passes/forward/environment.frag",
            Self::Irradiance(_) => "passes/forward/irradiance.frag",
        }
    }

    /// Returns the number of slope samples along a side of the grid.
    fn grid(self) -> Option<u32> {
        match self {
            Self::Environment(n) | Self::Irradiance(n) => Some(n),
            _ => None,
        }
    }

    /// Returns the number of slope samples.
    pub fn samples(self) -> u32 {
        self.grid().map_or(1, |n| n * n)
    }
}

impl fmt::Display for Forward {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant => write!(f, "forward constant"),
            Self::BlinnPhong => write!(f, "forward blinn-phong"),
            Self::Lean => write!(f, "forward lean"),
            Self::Leadr => write!(f, "forward leadr"),
            Self::Environment(n) => write!(f, "forward {n}x{n}, mirrored"),
            Self::Irradiance(n) => write!(f, "forward {n}x{n}, diffuse"),
        }
    }
}

shared_struct! {
    /// The uniform block of all stages.
    struct ForwardGpu for "Forward" {
        clip_from_world: [[f32; 4]; 4],
        camera_position: [f32; 4],
        sun_direction: [f32; 4],
        sun_irradiance: [f32; 4],
        /// The albedo, and the Beckmann roughness in w.
        material: [f32; 4],
        /// The F0, the height scale, and the number of texels along an edge of the environment cube.
        surface: [f32; 4],
        radiance_sh: [[f32; 4]; 9],
    }
}

shared_struct! {
    struct CornerGpu for "Corner" {
        /// The position, and the first texture coordinate in w.
        position: [f32; 4],
        /// The normal, and the second texture coordinate in w.
        normal: [f32; 4],
        tangent: [f32; 4],
        bitangent: [f32; 4],
    }
}

const STRUCTS: [StructLayout; 2] = [ForwardGpu::LAYOUT, CornerGpu::LAYOUT];

/// The forward pass on a device, with its quad, maps and target.
pub struct ForwardPass {
    gpu: Arc<Gpu>,
    timestamps: Timestamps,
    pipelines: Vec<(Forward, GraphicsPipeline)>,
    block: Buffer,
    corners: Buffer,
    maps: LeadrMapGpu,
    repeat: Sampler,
    clamp: Sampler,
    target: Image,
}

impl ForwardPass {
    /// Creates a pass over the only patch of `object`, whose heights must repeat. The light of `state` and an environment
    /// light the patch, and the picture has `size` pixels. `face_size` is the edge of the environment cube in texels, and
    /// `radiance_sh` are the nine SH coefficients of the environment's radiance.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the object is unsuitable, the number of coefficients is wrong, or there is no sun.
    /// Also fails if memory runs out or a pipeline cannot be created.
    pub fn new(
        gpu: &Arc<Gpu>,
        object: &Object,
        state: &FrameState,
        face_size: u32,
        radiance_sh: &[[f32; 4]],
        size: (u32, u32),
    ) -> Result<Self> {
        let fault = |fault: &str| GpuError::Usage { name: FORWARD.to_owned(), fault: fault.to_owned() };
        let (Some(field), [patch], [texcoords]) =
            (&object.heights, object.mesh.patches.as_slice(), object.mesh.texcoords.as_slice())
        else {
            return Err(fault("the object is not one patch with heights"));
        };
        let sun = state.sun().ok_or_else(|| fault("there is no sun"))?;
        let four = |v: Vec3, w: f32| v.extend(w).to_array();
        let [r, g, b, alpha] = object.mesh.colors[patch[0] as usize];
        let block = ForwardGpu {
            clip_from_world: state.camera.clip_from_world(size, Vec2::ZERO).to_cols_array_2d(),
            camera_position: four(state.camera.position, 1.0),
            sun_direction: four(sun.direction, 0.0),
            sun_irradiance: four(sun.irradiance, 0.0),
            material: [r, g, b, alpha],
            surface: [object.specular_f0, state.height_scale * object.height_scale, face_size as f32, 0.0],
            radiance_sh: radiance_sh.try_into().map_err(|_| fault("there must be nine coefficients"))?,
        };
        let corner_position = |corner: usize| object.mesh.positions[patch[corner] as usize];
        let across = texcoords[1].x - texcoords[0].x;
        let down = texcoords[3].y - texcoords[0].y;
        let corner = |i: usize| CornerGpu {
            position: four(corner_position(i), texcoords[i].x),
            normal: four(object.mesh.normals[patch[i] as usize], texcoords[i].y),
            tangent: four((corner_position(1) - corner_position(0)) / across, 0.0),
            bitangent: four((corner_position(3) - corner_position(0)) / down, 0.0),
        };
        let pipeline = |kind: Forward| {
            let grid = kind.grid().map(|n| ("GRID", SpecValue::I32(n as i32)));
            let desc = GraphicsDesc {
                vertex: "passes/forward/forward.vert",
                fragment: Some(kind.shader()),
                colors: &[RADIANCE_FORMAT],
                spec: grid.as_slice(),
                structs: &STRUCTS,
                ..Default::default()
            };
            Ok((kind, GraphicsPipeline::new(gpu, &kind.to_string(), &desc)?))
        };
        let uniform = Buffer::new(gpu, "forward", size_of::<ForwardGpu>() as u64, Memory::Upload)?;
        uniform.write(0, &[block])?;
        Ok(Self {
            gpu: gpu.clone(),
            timestamps: Timestamps::new(gpu, 2)?,
            pipelines: Forward::ALL.into_iter().map(pipeline).collect::<Result<_>>()?,
            block: uniform,
            corners: Buffer::from_slice(gpu, "forward corners", &[0, 1, 2, 3].map(corner))?,
            maps: LeadrMapGpu::new(gpu, &field.map, Border::Wrap, MomentFormat::Float32)?,
            repeat: Sampler::new(gpu, Filter::Trilinear, AddressMode::Repeat)?,
            clamp: Sampler::new(gpu, Filter::Trilinear, AddressMode::ClampToEdge)?,
            target: Image::new(gpu, FORWARD, ImageDesc::new(RADIANCE_FORMAT, size.0, size.1).color_target())?,
        })
    }

    /// Draws a picture `repeats` times, lit by the environment `cube`, and returns the time of one repetition.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] for a kind that is not in [`Forward::ALL`]. Also fails if the device is lost.
    pub fn measure(&self, kind: Forward, cube: &ImageView, repeats: u32) -> Result<PassTime> {
        let pipeline = self.pipelines.iter().find(|(made, _)| *made == kind).map(|(_, pipeline)| pipeline);
        let Some(pipeline) = pipeline else {
            return Err(GpuError::Usage { name: kind.to_string(), fault: "it is not in Forward::ALL".to_owned() });
        };
        self.gpu.submit(FORWARD, |cmd| {
            cmd.reset_timestamps(&self.timestamps);
            cmd.timestamp(&self.timestamps, "begin");
            cmd.label_times(FORWARD, repeats.max(1), |cmd| self.record(cmd, kind, pipeline, cube));
            cmd.timestamp(&self.timestamps, FORWARD);
        })?;
        let total: f64 = self.timestamps.intervals()?.iter().map(|(_, milliseconds)| milliseconds).sum();
        Ok(PassTime { pass: FORWARD.to_owned(), milliseconds: total / f64::from(repeats.max(1)) })
    }

    fn record(&self, cmd: &mut Commands, kind: Forward, pipeline: &GraphicsPipeline, cube: &ImageView) {
        cmd.image_barrier(&self.target, Use::Undefined, Use::ColorTarget);
        cmd.begin_rendering(&[ColorTarget { view: self.target.whole(), load: Load::Discard }], None);
        let mut bound =
            vec![("forward", Descriptor::Uniform(&self.block)), ("Corners", Descriptor::Storage(&self.corners))];
        if kind != Forward::Constant {
            bound.push(("slope_map", Descriptor::Sampled(self.maps.slopes.whole(), &self.repeat)));
        }
        if !matches!(kind, Forward::Constant | Forward::BlinnPhong) {
            bound.push(("joint_map", Descriptor::Sampled(self.maps.joint.whole(), &self.repeat)));
        }
        if let Forward::Environment(_) = kind {
            bound.push(("environment_cube", Descriptor::Sampled(cube, &self.clamp)));
        }
        cmd.bind(pipeline, &bound);
        cmd.draw(0..6, 0..1);
        cmd.end_rendering();
    }

    /// Returns the linear radiance of the last picture, row by row from the top.
    ///
    /// # Errors
    /// Fails if the device is lost or memory runs out.
    pub fn picture(&self) -> Result<Vec<[f32; 4]>> {
        self.target.read(0, 0)
    }
}
