//! Draws a view of a baked material into a float image for readback.

use std::path::Path;

use wgpu::naga::ShaderStage;
use wgpu::util::DeviceExt as _;

use crate::baked::Baked;
use crate::includes::expand;
use crate::view::View;

/// A picture of linear radiance, in rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The width and height in pixels.
    pub size: [u32; 2],
    /// Red, green, blue, and 1 for each pixel.
    pub pixels: Vec<[f32; 4]>,
}

/// Draws `view` of `baked`. `shaders` is the folder that contains `leadr`, the folder of includes.
///
/// # Errors
/// Returns a message if there is no Vulkan driver, if the device cannot filter 32-bit floats, or if a shader is missing.
pub fn draw(baked: &Baked, view: &View, shaders: &Path) -> Result<Picture, String> {
    pollster::block_on(drawn(baked, view, shaders))
}

const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

async fn drawn(baked: &Baked, view: &View, shaders: &Path) -> Result<Picture, String> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let fragment = expand(shaders, &own.join("plane.frag"))?;
    let vertex = expand(shaders, &own.join("plane.vert"))?;

    let mut instance = wgpu::InstanceDescriptor::new_without_display_handle();
    instance.backends = wgpu::Backends::VULKAN;
    let instance = wgpu::Instance::new(instance);
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await;
    let adapter = adapter.map_err(|error| format!("wgpu found no Vulkan driver: {error}"))?;
    let filtered = wgpu::Features::FLOAT32_FILTERABLE;
    if !baked.half && !adapter.features().contains(filtered) {
        return Err("this device cannot filter floats of 32 bits; bake with --format f16".into());
    }
    let device = wgpu::DeviceDescriptor { required_features: adapter.features() & filtered, ..Default::default() };
    let (device, queue) = adapter.request_device(&device).await.map_err(|error| error.to_string())?;

    let uniforms = |label, contents: &[u8]| {
        let usage = wgpu::BufferUsages::UNIFORM;
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
    };
    let view_block = uniforms("view", bytemuck::bytes_of(&view.block()));
    let [first, second, color] = baked.scale;
    let scales = [first, second, color, [baked.color_layer as f32, 0.0, 0.0, 0.0]];
    let baked_block = uniforms("baked", bytemuck::bytes_of(&scales));
    let map = upload(&device, &queue, baked);
    let map = map.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("repeating"),
        address_mode_u: wgpu::AddressMode::Repeat,
        address_mode_v: wgpu::AddressMode::Repeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    });

    let module = |label, source: &str, stage| {
        let source = wgpu::ShaderSource::Glsl { shader: source.to_owned().into(), stage, defines: &[] };
        device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
    };
    let vertex = module("plane.vert", &vertex, ShaderStage::Vertex);
    let fragment = module("plane.frag", &fragment, ShaderStage::Fragment);
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("plane"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &vertex,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &fragment,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            targets: &[Some(TARGET.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("plane"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            entry(0, view_block.as_entire_binding()),
            entry(1, baked_block.as_entire_binding()),
            entry(2, wgpu::BindingResource::TextureView(&map)),
            entry(3, wgpu::BindingResource::Sampler(&sampler)),
        ],
    });

    let [width, height] = view.size;
    let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: extent,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TARGET,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let row = (16 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("copy of the picture"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut commands = device.create_command_encoder(&Default::default());
    {
        let attachment = wgpu::RenderPassColorAttachment {
            view: &target.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        };
        let mut pass = commands.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("plane"),
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: Some(height) };
    commands.copy_texture_to_buffer(
        target.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &copy, layout },
        extent,
    );
    queue.submit([commands.finish()]);
    copy.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("the copy can be read"));
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
    let bytes = copy.slice(..).get_mapped_range().map_err(|error| error.to_string())?;
    let rows = bytes.chunks_exact(row as usize);
    let pixels = rows.flat_map(|row| bytemuck::pod_collect_to_vec(&row[..16 * width as usize])).collect();
    Ok(Picture { size: view.size, pixels })
}

fn upload(device: &wgpu::Device, queue: &wgpu::Queue, baked: &Baked) -> wgpu::Texture {
    let [width, height] = baked.size;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("baked map"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: baked.layers },
        mip_level_count: baked.levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: if baked.half { wgpu::TextureFormat::Rgba16Float } else { wgpu::TextureFormat::Rgba32Float },
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let texel = if baked.half { 8 } else { 16 };
    for (mip_level, bytes) in (0..).zip(&baked.levels) {
        let [width, height] = baked.size.map(|side| (side >> mip_level).max(1));
        queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() },
            bytes,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * texel), rows_per_image: Some(height) },
            wgpu::Extent3d { width, height, depth_or_array_layers: baked.layers },
        );
    }
    texture
}

impl Picture {
    /// Saves linear radiance to an `.exr` file. For other formats, the radiance is multiplied by `exposure`, and a soft shoulder is
    /// applied.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path, exposure: f32) -> Result<(), String> {
        let [width, height] = self.size;
        let fault = |error: image::ImageError| format!("{}: {error}", path.display());
        if path.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("exr")) {
            let linear = self.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
            let image = image::Rgb32FImage::from_raw(width, height, linear).expect("the pixel count matches the size");
            return image.save(path).map_err(fault);
        }
        let shown = |radiance: f32| {
            let x = (radiance * exposure).max(0.0);
            let linear = x * (1.0 + x / 9.0) / (1.0 + x);
            let srgb = if linear < 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
            (255.0 * srgb.clamp(0.0, 1.0) + 0.5) as u8
        };
        let bytes = self.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b].map(shown)).collect();
        let image = image::RgbImage::from_raw(width, height, bytes).expect("the pixel count matches the size");
        image.save(path).map_err(fault)
    }
}
