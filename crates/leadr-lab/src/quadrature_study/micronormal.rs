//! Compares the artificial micronormal of the paper's supplement (3.7) with [`face_viewer`] and [`tilt_to_edge`], on the silhouette of a sphere
//! of few triangles.

use super::samplers::{Filter, Node, cosine, radiance};
use super::specular::{Lobes, Sharpness, converged_radiance};
use super::surfaces::Surface;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use leadr_reflectance::facets::projected_area::{face_viewer, meso_area, tilt_to_edge, visible_area};
use leadr_reflectance::frame::{frame_about, to_frame};
use leadr_reflectance::integrals::slope_nodes::{NodePlacement, slope_nodes};
use leadr_reflectance::limits::MIN_AREA;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::{facet_area, grid_lambda, grid_nodes, grid_spacing, slope_at, slope_cholesky};
use rayon::prelude::*;

/// The nodes per axis of the grid.
const N: u32 = 5;
/// The number of pixels across the sphere. The triangles of four subdivisions then cover about 3 pixels each.
const PIXELS: u32 = 96;
const SUBDIVISIONS: u32 = 4;
/// The waves of the relief around the sphere.
const WAVES: f64 = 20.0;
/// Two results differ if they are further apart than this, in units of the mean radiance.
const VISIBLE: f64 = 0.01;

/// What gives pixels with a back-facing mesonormal a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// Nothing: a pixel without visible nodes is black.
    Nothing,
    /// [`NodePlacement::Micronormal`], the paper's method.
    Artificial,
    /// [`face_viewer`].
    FaceViewer,
    /// [`tilt_to_edge`], then [`face_viewer`], as in the renderer.
    TiltToEdge,
}

impl Remedy {
    /// All remedies.
    pub const ALL: [Self; 4] = [Self::Nothing, Self::Artificial, Self::FaceViewer, Self::TiltToEdge];

    /// Returns the statistics of the slopes that this remedy shades.
    fn surface(self, surface: &Surface) -> Surface {
        let Surface { wo, mut m, mut s } = *surface;
        if self == Self::TiltToEdge {
            let d = tilt_to_edge(wo, m);
            m += d;
            s += DVec3::new(d.x * d.x, d.y * d.y, d.x * d.y);
        }
        if matches!(self, Self::FaceViewer | Self::TiltToEdge) {
            m = face_viewer(wo, m, s, grid_lambda(N));
        }
        Surface { wo, m, s }
    }

    /// Returns the nodes of the 5×5 grid, and the artificial micronormal where it is the remedy.
    pub fn nodes(self, surface: &Surface) -> (Surface, Vec<Node>) {
        let shaded = self.surface(surface);
        let Surface { wo, m, s } = shaded;
        if self == Self::Artificial {
            return (shaded, slope_nodes(NodePlacement::Micronormal, wo, m, s, N).all(wo).collect());
        }
        let (lambda, c) = (grid_lambda(N), slope_cholesky(s));
        let cell = grid_spacing(N, lambda).powi(2);
        let total: f64 = grid_nodes(N, lambda).map(|p| p.z).sum();
        let node = |slope: DVec2, weight: f64| Node { slope, weight: weight * facet_area(wo, slope), cell };
        let nodes = grid_nodes(N, lambda).map(|p| node(slope_at(p.xy(), m, c), p.z / total));
        (shaded, nodes.collect())
    }
}

/// The differences on the sphere, for one roughness.
#[derive(Clone, Debug, PartialEq)]
pub struct MicronormalRow {
    /// The standard deviation of the slopes within a pixel.
    pub sigma: f64,
    /// The largest mean slope of the relief.
    pub relief: f64,
    /// The number of pixels of the sphere.
    pub pixels: usize,
    /// The number of pixels whose mesonormal faces away.
    pub away: usize,
    /// The number of pixels without a visible node, which are black without a remedy.
    pub black: usize,
    /// The remedies other than [`Remedy::Nothing`].
    pub remedies: [RemedyErrors; 3],
}

/// The errors of one remedy. Radiances are in units of the mean radiance of the environment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RemedyErrors {
    /// The number of pixels that differ by more than 0.01 from the artificial micronormal.
    pub different: usize,
    /// The RMS difference from the artificial micronormal over the back-facing pixels: specular radiance, then the cosine of a
    /// light from the viewer.
    pub difference: [f64; 2],
    /// The RMS error of the specular radiance over the back-facing pixels, against the converged integral of the same slopes.
    pub error: f64,
}

/// Returns the triangles of an icosahedron whose edges are halved `levels` times, on the unit sphere.
pub fn icosphere(levels: u32) -> Vec<[DVec3; 3]> {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let corners: Vec<DVec3> = [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)]
        .iter()
        .flat_map(|&(a, b)| [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)])
        .map(DVec3::normalize)
        .collect();
    let mut faces = Vec::new();
    let near = |a: DVec3, b: DVec3| a.dot(b) > 0.4;
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in &corners[j + 1..] {
                if near(a, b) && near(b, c) && near(a, c) {
                    faces.push(if (b - a).cross(c - a).dot(a) > 0.0 { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..levels {
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    faces
}

/// Returns the points of the triangles that face a distant viewer on the positive z axis, one per covered pixel.
fn visible_points() -> Vec<DVec3> {
    // A slight rotation hides the symmetry of the triangles.
    let rotate = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.31, 0.47, 0.13);
    let faces: Vec<[DVec3; 3]> = icosphere(SUBDIVISIONS)
        .into_iter()
        .map(|f| f.map(|v| rotate * v))
        .filter(|[a, b, c]| (*b - *a).cross(*c - *a).z > 0.0)
        .collect();
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(PIXELS) * 2.0 - 1.0;
    (0..PIXELS * PIXELS)
        .into_par_iter()
        .filter_map(|i| {
            let p = DVec2::new(at(i % PIXELS), at(i / PIXELS));
            let cross = |a: DVec2, b: DVec2| a.perp_dot(b);
            faces
                .iter()
                .filter_map(|[a, b, c]| {
                    let weights = [(b, c), (c, a), (a, b)].map(|(u, v)| cross(u.xy() - p, v.xy() - p));
                    let sum: f64 = weights.iter().sum();
                    weights
                        .iter()
                        .all(|&w| w >= 0.0)
                        .then(|| (weights[0] * *a + weights[1] * *b + weights[2] * *c) / sum)
                })
                .max_by(|a, b| a.z.total_cmp(&b.z))
        })
        .collect()
}

/// Measures the remedies on a sphere of few triangles, whose relief has mean slopes up to `relief` per axis and the standard deviation
/// `sigma` within a pixel. The environment is six smooth lobes.
pub fn micronormal_row(sigma: f64, relief: f64, seed: u64) -> MicronormalRow {
    let lobes = Lobes::random(&mut Random(seed), Sharpness::Smooth);
    let surfaces: Vec<Surface> = visible_points()
        .into_iter()
        .map(|p| {
            let n = p.normalize();
            let m = relief * DVec2::new((WAVES * n.x).sin(), (WAVES * n.y).cos());
            Surface { wo: to_frame(&frame_about(n), DVec3::Z), m, s: DVec3::new(sigma * sigma, sigma * sigma, 0.0) }
        })
        .collect();
    let away: Vec<Surface> = surfaces.iter().copied().filter(|s| meso_area(s.wo, s.m) < 0.0).collect();
    let values = |remedy: Remedy, s: &Surface| {
        let (shaded, nodes) = remedy.nodes(s);
        [radiance(&shaded, &lobes, &nodes, Filter::Widest), cosine(&nodes, s.wo)]
    };
    let is_black = |s: &&Surface| Remedy::Nothing.nodes(s).1.iter().all(|p| p.weight == 0.0);
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, n) = values.fold((0.0, 0u32), |(sum, n), v| (sum + v * v, n + 1));
        (sum / f64::from(n.max(1))).sqrt()
    };
    let remedies = [Remedy::Artificial, Remedy::FaceViewer, Remedy::TiltToEdge].map(|remedy| {
        let differences: Vec<[f64; 2]> = away
            .par_iter()
            .map(|s| {
                let (a, b) = (values(remedy, s), values(Remedy::Artificial, s));
                [a[0] - b[0], a[1] - b[1]]
            })
            .collect();
        let errors: Vec<f64> = away
            .par_iter()
            // The integral divides by no less than this area.
            .filter(|s| visible_area(s.wo, s.m, s.s) > MIN_AREA)
            .map(|s| values(remedy, s)[0] - converged_radiance(s, &lobes, 20.0))
            .collect();
        RemedyErrors {
            different: differences.iter().filter(|d| d[0].abs().max(d[1].abs()) > VISIBLE).count(),
            difference: [0, 1].map(|k| rms(&mut differences.iter().map(|d| d[k]))),
            error: rms(&mut errors.into_iter()),
        }
    });
    let black = away.iter().filter(is_black).count();
    MicronormalRow { sigma, relief, pixels: surfaces.len(), away: away.len(), black, remedies }
}

#[cfg(test)]
mod tests {
    use super::super::samplers::{moments, solid_angle};
    use super::*;

    #[test]
    fn the_icosphere_is_closed() {
        let faces = icosphere(2);
        assert_eq!(faces.len(), 320);
        let area: DVec3 = faces.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a)).sum();
        assert!(area.length() < 1e-12);
        assert!(faces.iter().all(|[a, b, c]| (*b - *a).cross(*c - *a).dot(*a) > 0.0));
    }

    #[test]
    fn every_remedy_leaves_front_facing_pixels() {
        let s = Surface { wo: DVec3::new(0.6, 0.0, 0.8), m: DVec2::new(0.2, 0.1), s: DVec3::new(0.04, 0.04, 0.0) };
        let plain = moments(&Remedy::Nothing.nodes(&s).1);
        for remedy in Remedy::ALL {
            let (shaded, nodes) = remedy.nodes(&s);
            let found = moments(&nodes);
            assert!((found.mean - plain.mean).length() < 1e-12, "{remedy:?}");
            assert!((found.diag - plain.diag).length() + (found.off - plain.off).length() < 1e-12, "{remedy:?}");
            assert!(nodes.iter().all(|p| solid_angle(&shaded, p, Filter::Widest).is_finite()));
        }
    }

    #[test]
    fn only_the_artificial_micronormal_is_left_of_a_hidden_grid() {
        let s = Surface { wo: DVec3::new(0.8, 0.0, 0.6), m: DVec2::new(2.0, 0.0), s: DVec3::new(0.01, 0.01, 0.0) };
        let sum = |remedy: Remedy| remedy.nodes(&s).1.iter().map(|p| p.weight).sum::<f64>();
        assert_eq!(sum(Remedy::Nothing), 0.0);
        assert!(sum(Remedy::Artificial) > 0.0 && sum(Remedy::Artificial) < 1e-5);
        let mean = moments(&Remedy::Artificial.nodes(&s).1).mean;
        assert!((mean.length() - 1.0).abs() < 1e-9 && (0.0..0.02).contains(&mean.dot(s.wo)));
    }
}
