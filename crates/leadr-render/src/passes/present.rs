//! The present pass, which exposes and tonemaps the renderer's linear image into the image of a window, with the curves of
//! [`leadr_maps::tonemap`]. The resulting codes equal those in a PNG.

use std::sync::Arc;

use leadr_gpu::vk;

use leadr_gpu::{
    AddressMode, ColorTarget, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Image, Load, Result,
    Sampler, SharedStruct, SpecValue, Use, shared_struct,
};
use leadr_maps::tonemap::Tonemap;

shared_struct! {
    struct Constants for "Constants" {
        /// The exposure factor for the radiance.
        exposure: f32,
        /// The fraction of the width that shows the first image.
        split: f32,
        /// 1 to dither before rounding to codes, 0 to round to the nearest code.
        dithering: f32,
    }
}

/// The pipeline of the present pass.
pub struct PresentPass {
    pipeline: GraphicsPipeline,
    /// The samplers for images of the target's size, and of other sizes.
    samplers: [Sampler; 2],
}

/// The input of the present pass.
#[derive(Clone, Copy)]
pub struct Presented<'a> {
    /// The image of linear radiance.
    pub image: &'a Image,
    /// A second image on the right, and the fraction of the width for the first image.
    pub beside: Option<(&'a Image, f32)>,
    /// The exposure factor for the radiance.
    pub exposure: f32,
    /// Whether codes are dithered ([`leadr_maps::tonemap::dither`]).
    pub dithered: bool,
}

impl PresentPass {
    /// Creates the pass for targets of one format. sRGB formats encode the colours themselves. For linear formats, the pass writes
    /// sRGB codes.
    pub fn new(gpu: &Arc<Gpu>, format: vk::Format, tonemap: Tonemap) -> Result<Self> {
        let target_encodes = matches!(format, vk::Format::B8G8R8A8_SRGB | vk::Format::R8G8B8A8_SRGB);
        let pipeline = GraphicsPipeline::new(
            gpu,
            "present",
            &GraphicsDesc {
                vertex: "passes/fullscreen.vert",
                fragment: Some("passes/present.frag"),
                colors: &[format],
                spec: &[("TONEMAP", SpecValue::I32(tonemap as i32)), ("ENCODE_SRGB", SpecValue::Bool(!target_encodes))],
                structs: &[Constants::LAYOUT],
                ..Default::default()
            },
        )?;
        let sampler = |filter| Sampler::new(gpu, filter, AddressMode::ClampToEdge);
        Ok(Self { pipeline, samplers: [sampler(Filter::Nearest)?, sampler(Filter::Bilinear)?] })
    }

    /// Draws images over the whole `target`, which ends in [`Use::ColorTarget`]. Images of a different size are stretched.
    pub fn record(
        &self,
        cmd: &mut Commands,
        Presented { image, beside, exposure, dithered }: Presented<'_>,
        target: &Image,
    ) {
        let (other, split) = beside.unwrap_or((image, 2.0));
        let extent = target.mip_extent(0);
        let sampled = |image: &Image| &self.samplers[usize::from(image.mip_extent(0) != extent)];
        cmd.transition(image, Use::Sampled);
        cmd.transition(other, Use::Sampled);
        cmd.image_barrier(target, Use::Undefined, Use::ColorTarget);
        cmd.begin_rendering(&[ColorTarget { view: target.whole(), load: Load::Discard }], None);
        let of = |image| Descriptor::Sampled(Image::whole(image), sampled(image));
        cmd.bind(&self.pipeline, &[("image", of(image)), ("other", of(other))]);
        cmd.push_constants(&Constants { exposure, split, dithering: f32::from(u8::from(dithered)) });
        cmd.draw(0..3, 0..1);
        cmd.end_rendering();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_gpu::{DriverCall, GpuError, GpuOptions, ImageDesc};
    use leadr_maps::tonemap::{display_srgb8, dithered_srgb8};

    /// Returns a ramp of radiance over 18 stops, with both signs and with non-finite values.
    fn ramp() -> Vec<[f32; 4]> {
        let mut texels: Vec<[f32; 4]> = (0..1020)
            .map(|i| {
                let x = (i as f32 / 1019.0 * 18.0 - 12.0).exp2();
                [x, 0.5 * x, 2.0 * x, 0.3]
            })
            .collect();
        texels.push([-1.0, 0.0, -1e30, 1.0]);
        texels.push([f32::INFINITY, 1e30, 1e4, 1.0]);
        texels.push([0.5, f32::NAN, 0.5, 1.0]);
        texels.push([0.0, 0.0, 0.0, f32::NAN]);
        texels
    }

    /// Returns the largest code difference between the ramp in a target of one format and the CPU's curve, and the fraction of
    /// different codes. Dithering is on if the exposure is not 1.
    fn difference(gpu: &Arc<Gpu>, format: vk::Format, shader: Tonemap, exposure: f32, cpu: Tonemap) -> (u8, f32) {
        let dithered = exposure != 1.0;
        let texels = ramp();
        let image = Image::new(gpu, "ramp", ImageDesc::new(vk::Format::R32G32B32A32_SFLOAT, 32, 32)).unwrap();
        image.write(0, 0, &texels).unwrap();
        let target = Image::new(gpu, "codes", ImageDesc::new(format, 32, 32).color_target()).unwrap();
        let pass = PresentPass::new(gpu, format, shader).unwrap();
        let shown = Presented { image: &image, beside: None, exposure, dithered };
        gpu.submit("present", |cmd| pass.record(cmd, shown, &target)).unwrap();
        let codes: Vec<[u8; 4]> = target.read(0, 0).unwrap();
        let (mut worst, mut others) = (0, 0);
        for (i, (texel, code)) in texels.iter().zip(&codes).enumerate() {
            let (color, pixel) = ([texel[0], texel[1], texel[2]], [i as u32 % 32, i as u32 / 32]);
            let expected = match dithered {
                true => dithered_srgb8(color, exposure, cpu, pixel),
                false => display_srgb8(color, exposure, cpu),
            };
            let blue_first = matches!(format, vk::Format::B8G8R8A8_UNORM | vk::Format::B8G8R8A8_SRGB);
            let shown = if blue_first { [code[2], code[1], code[0]] } else { [code[0], code[1], code[2]] };
            assert_eq!(code[3], 255);
            for (shown, expected) in shown.iter().zip(expected) {
                worst = worst.max(shown.abs_diff(expected));
                others += u32::from(*shown != expected);
            }
        }
        (worst, others as f32 / (3 * texels.len()) as f32)
    }

    #[test]
    fn window_pixels_equal_png_codes() {
        let options = GpuOptions { device: std::env::var("LEADR_DEVICE").ok(), validation: true, ..Default::default() };
        let gpu = match crate::open_gpu(&options) {
            Ok(gpu) => gpu,
            Err(error @ GpuError::Vulkan { .. }) => panic!("{error}"),
            Err(error) if std::env::var("LEADR_SKIP_GPU").is_ok_and(|value| value == "1") => {
                return println!("skipped, since LEADR_SKIP_GPU=1: {error}");
            }
            Err(error) => panic!("this test needs a GPU (LEADR_SKIP_GPU=1 skips it): {error}"),
        };
        for format in [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_SRGB] {
            for tonemap in Tonemap::ALL {
                for exposure in [1.0, 2.5] {
                    let (worst, others) = difference(&gpu, format, tonemap, exposure, tonemap);
                    // Two roundings of the same curve differ by at most one code, and rarely. lavapipe approximates the codes of sRGB
                    // formats; a tenth of them differ.
                    let most = if format == vk::Format::R8G8B8A8_SRGB { 0.2 } else { 0.02 };
                    assert!(worst <= 1 && others < most, "{format:?} {tonemap:?} {exposure}: {worst} codes, {others}");
                }
            }
        }
        // A different curve is detected.
        let (other, _) = difference(&gpu, vk::Format::R8G8B8A8_UNORM, Tonemap::Clamp, 1.0, Tonemap::Filmic);
        assert!(other > 20, "{other}");
        newer_shaders_are_drawn_with_once_they_fit(&gpu);
        assert_eq!(gpu.validation_messages(), Vec::<String>::new());
    }

    /// The test above calls this function, because all pipelines of a process share their shaders.
    fn newer_shaders_are_drawn_with_once_they_fit(gpu: &Arc<Gpu>) {
        use leadr_gpu::shader_watch::CompiledShaders;

        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders-glsl");
        let source = std::fs::read_to_string(root.join("passes/present.frag")).unwrap();
        let changed = |from: &str, to: &str| {
            assert!(source.contains(from), "{from}");
            let folder = tempfile::tempdir().unwrap();
            std::fs::create_dir(folder.path().join("passes")).unwrap();
            std::fs::copy(root.join("passes/tonemap.glsl"), folder.path().join("passes/tonemap.glsl")).unwrap();
            std::fs::write(folder.path().join("passes/present.frag"), source.replace(from, to)).unwrap();
            CompiledShaders::compile(folder.path(), &["passes/present.frag".to_owned()]).unwrap()
        };
        let image = Image::new(gpu, "grey", ImageDesc::new(vk::Format::R32G32B32A32_SFLOAT, 4, 4)).unwrap();
        image.write(0, 0, &[[0.5f32; 4]; 16]).unwrap();
        let format = vk::Format::R8G8B8A8_UNORM;
        let target = Image::new(gpu, "codes", ImageDesc::new(format, 4, 4).color_target()).unwrap();
        let pass = PresentPass::new(gpu, format, Tonemap::Clamp).unwrap();
        let shown = || {
            let shown = Presented { image: &image, beside: None, exposure: 1.0, dithered: false };
            gpu.submit("present", |cmd| pass.record(cmd, shown, &target)).unwrap();
            target.read::<[u8; 4]>(0, 0).unwrap()[0]
        };
        assert_eq!(shown(), [188, 188, 188, 255]);
        // A shader that swaps two colours can be compiled into the existing pipeline.
        let red = changed("vec4(display, 1.0)", "vec4(display.r, 0.0, 0.0, 1.0)");
        assert_eq!(gpu.take_shaders(red).unwrap(), 1);
        assert_eq!(shown(), [188, 0, 0, 255]);
        // A shader with a different block layout does not fit the pipeline, and nothing changes.
        let foreign = changed("float split;", "vec4 split4; float split;");
        let message = gpu.take_shaders(foreign).unwrap_err().to_string();
        assert!(message.contains("Constants"), "{message}");
        assert_eq!(shown(), [188, 0, 0, 255]);
        // Nothing changes either if the driver refuses the pipeline.
        let back = || changed("vec4(display, 1.0)", "vec4(display, 1.0) ");
        gpu.fail_after(0, DriverCall::Pipeline);
        let message = gpu.take_shaders(back()).unwrap_err().to_string();
        assert!(message.contains("present"), "{message}");
        assert_eq!(shown(), [188, 0, 0, 255]);
        assert_eq!(gpu.take_shaders(back()).unwrap(), 1);
        assert_eq!(shown(), [188, 188, 188, 255]);
    }
}
