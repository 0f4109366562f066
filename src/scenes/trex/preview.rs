//! Pictures of the cage for people: an orthographic z-buffer of the tessellated patches.

use std::path::Path;

use glam::{Vec2, Vec3};

use crate::render::surfaces::patch::Patch;
use crate::render::surfaces::patch_mesh::PatchMesh;

/// An orthographic view: centre of the picture, width in metres, direction towards the viewer (degrees).
#[derive(Clone, Copy)]
pub struct View {
    pub center: Vec3,
    pub width: f32,
    pub azimuth: f32,
    pub elevation: f32,
    pub size: [usize; 2],
}

/// What is drawn.
pub struct Canvas {
    view: View,
    depth: Vec<f32>,
    color: Vec<[u8; 3]>,
}

impl Canvas {
    pub fn new(view: View) -> Self {
        let count = view.size[0] * view.size[1];
        Self { view, depth: vec![f32::MIN; count], color: vec![[205, 212, 222]; count] }
    }

    fn axes(&self) -> (Vec3, Vec3, Vec3) {
        let (a, e) = (self.view.azimuth.to_radians(), self.view.elevation.to_radians());
        let towards = Vec3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin());
        let right = Vec3::Z.cross(towards).normalize();
        (right, towards.cross(right), towards)
    }

    fn triangle(&mut self, p: [Vec3; 3], shade: [f32; 3], line: impl Fn(Vec3) -> f32) {
        let (right, up, towards) = self.axes();
        let [w, h] = self.view.size;
        let scale = w as f32 / self.view.width;
        let s = p.map(|q| {
            let o = q - self.view.center;
            Vec3::new(w as f32 * 0.5 + o.dot(right) * scale, h as f32 * 0.5 - o.dot(up) * scale, o.dot(towards))
        });
        let cross = |a: Vec2, b: Vec2| a.perp_dot(b);
        let area = cross((s[1] - s[0]).truncate(), (s[2] - s[0]).truncate());
        let (low, high) = (s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2]));
        for y in low.y.max(0.0) as usize..=(high.y.min(h as f32 - 1.0).max(0.0) as usize) {
            for x in low.x.max(0.0) as usize..=(high.x.min(w as f32 - 1.0).max(0.0) as usize) {
                let q = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let b0 = cross(s[1].truncate() - q, s[2].truncate() - q) / area;
                let b1 = cross(s[2].truncate() - q, s[0].truncate() - q) / area;
                let b2 = 1.0 - b0 - b1;
                if b0 < 0.0 || b1 < 0.0 || b2 < 0.0 {
                    continue;
                }
                let z = b0 * s[0].z + b1 * s[1].z + b2 * s[2].z;
                let i = y * w + x;
                if z > self.depth[i] {
                    self.depth[i] = z;
                    let l = line(Vec3::new(b0, b1, b2)) * (b0 * shade[0] + b1 * shade[1] + b2 * shade[2]);
                    let c = (l.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0) as u8;
                    // Back faces show red.
                    self.color[i] = if area < 0.0 { [c, c, (f32::from(c) * 0.93) as u8] } else { [255, 40, 40] };
                }
            }
        }
    }

    /// Draws all patches tessellated `n` times, with darkened patch edges if `edges`.
    pub fn patches(&mut self, mesh: &PatchMesh, n: usize, edges: bool) {
        let light = [(Vec3::new(0.35, 0.55, 0.75).normalize(), 0.75), (Vec3::new(0.6, -0.7, 0.1).normalize(), 0.18)];
        for corners in &mesh.patches {
            let at = |v: &Vec<Vec3>| corners.map(|i| v[i as usize]);
            let patch = Patch::new(at(&mesh.positions), at(&mesh.normals));
            let open = corners.map(|i| mesh.accessibility.get(i as usize).copied().unwrap_or(1.0));
            for j in 0..n {
                for i in 0..n {
                    let corner = |di: usize, dj: usize| {
                        let uv = Vec2::new((i + di) as f32, (j + dj) as f32) / n as f32;
                        let point = patch.at(uv);
                        let normal = point.du.cross(point.dv).normalize_or_zero();
                        let ambient = (open[0] * (1.0 - uv.x) + open[1] * uv.x) * (1.0 - uv.y)
                            + (open[3] * (1.0 - uv.x) + open[2] * uv.x) * uv.y;
                        let lit: f32 = light.iter().map(|(d, s)| s * normal.dot(*d).max(0.0)).sum();
                        (point.position, uv, 0.12 * ambient + lit * (0.3 + 0.7 * ambient))
                    };
                    let c = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    for t in [[0, 1, 2], [0, 2, 3]] {
                        let line = |b: Vec3| {
                            let uv = c[t[0]].1 * b.x + c[t[1]].1 * b.y + c[t[2]].1 * b.z;
                            let near = uv.min(1.0 - uv).min_element();
                            if edges && near < 0.04 { 0.25 } else { 1.0 }
                        };
                        self.triangle(t.map(|k| c[k].0), t.map(|k| c[k].2), line);
                    }
                }
            }
        }
    }

    pub fn save(&self, path: &Path) {
        let [w, h] = self.view.size;
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        image::save_buffer(path, self.color.as_flattened(), w as u32, h as u32, image::ColorType::Rgb8).unwrap();
    }
}

/// The most useful views.
pub fn views() -> Vec<(&'static str, View)> {
    let v = |center: [f32; 3], width, azimuth, elevation, size| View {
        center: Vec3::from(center),
        width,
        azimuth,
        elevation,
        size,
    };
    vec![
        ("side", v([-0.9, 0.0, 2.1], 12.2, 90.0, 3.0, [1400, 520])),
        ("front", v([0.0, 0.0, 2.1], 3.4, 0.0, 4.0, [600, 800])),
        ("head", v([4.05, 0.0, 3.65], 2.0, 50.0, 8.0, [1000, 800])),
        ("feet", v([0.3, 0.3, 0.6], 1.8, 50.0, 15.0, [900, 700])),
    ]
}

#[test]
#[ignore = "pictures, for people"]
fn rest_pictures() {
    let sdf = super::sdf::TrexSdf::new();
    let mesh = super::cage::build(&sdf).unwrap();
    for (name, view) in views() {
        for edges in [false, true] {
            let mut canvas = Canvas::new(view);
            canvas.patches(&mesh, 5, edges);
            canvas.save(Path::new(&format!("out/trex_{name}{}.png", if edges { "_edges" } else { "" })));
        }
    }
}

fn posed(mesh: &PatchMesh, time: f64) -> PatchMesh {
    let now = crate::render::surfaces::skinning::skin(mesh, &super::walk::pose_in_place(time).skinning_matrices());
    PatchMesh { positions: now.positions, normals: now.normals, ..mesh.clone() }
}

#[test]
#[ignore = "pictures, for people"]
fn walk_pictures() {
    let sdf = super::sdf::TrexSdf::new();
    let mesh = super::cage::build(&sdf).unwrap();
    for k in 0..8 {
        let now = posed(&mesh, super::gait::PERIOD * f64::from(k) / 8.0);
        for (name, view) in views().into_iter().filter(|v| k % 2 == 0 || v.0 == "feet" || v.0 == "side") {
            let mut canvas = Canvas::new(View { size: [view.size[0] * 7 / 10, view.size[1] * 7 / 10], ..view });
            canvas.patches(&now, 4, false);
            canvas.save(Path::new(&format!("out/walk{k}_{name}.png")));
        }
    }
}
