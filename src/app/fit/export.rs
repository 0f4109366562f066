//! Exports a material of a few lobes, which fits the measurement best, to other renderers. The lobes are one GGX lobe, or the Gaussian lobes of
//! the fit. The material is a mixture of metals and a diffuse base, or a coat over a diffuse base. The fit uses the masking model of each
//! renderer.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};
use std::fmt;

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::coat::{Coat, MOST};
use leadr_reflectance::extraction::samples::{Misfit, Sample, misfit};
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::ellipse::{Ellipse, ellipse_from_roughness, roughness_from_ellipse};
use leadr_reflectance::facets::fresnel::{Fresnel, fresnel_conductor, fresnel_dielectric};
use leadr_reflectance::facets::gaussian_mixture::Lobe as Gaussian;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::microfacet::{Microfacet, microfacet_eval};

/// The refractive index of exported coats, typical of plastics and varnishes.
const COAT_INDEX: f64 = 1.5;

/// A renderer to which materials are exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Renderer {
    /// Mitsuba 3, which has independent masking and shadowing, and isotropic coats.
    Mitsuba,
    /// pbrt-v4, which has height-correlated masking and shadowing.
    Pbrt,
}

/// A material with a few lobes.
#[derive(Clone, Debug, PartialEq)]
pub struct Simple {
    renderer: Renderer,
    facets: Facets,
    surface: Surface,
}

/// The facets of a material. An ellipse has the half-axes of `α`, and the angle of the first half-axis from the tangent.
#[derive(Clone, Debug, PartialEq)]
enum Facets {
    /// One GGX lobe.
    Ggx(Ellipse),
    /// Several Beckmann lobes with their shares, which sum to one.
    Beckmann(Vec<(f64, Ellipse)>),
}

/// The surface under the lobes of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Surface {
    /// A metal of index `eta + i k` that covers the fraction `share` of a diffuse base of this albedo.
    Metal { share: f64, eta: DVec3, k: DVec3, albedo: DVec3 },
    /// A diffuse base of this albedo under a dielectric coat.
    Coated(DVec3),
}

/// The candidates for the fraction of metal.
const SHARES: [f64; 11] = [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.05];

/// The candidates for the `refraction` of [`index`], from 0 to 1. The first is tried with all fractions of metal, and the others with the
/// best fraction.
const REFRACTIONS: [f64; 3] = [0.5, 0.0, 1.0];

/// Whether an ellipse is a circle, whose angle has no meaning.
pub fn is_round(ellipse: &Ellipse) -> bool {
    (ellipse.radii.x - ellipse.radii.y).abs() < 1e-6 * ellipse.radii.x
}

/// Returns the circle with the same area.
fn rounded(ellipse: Ellipse) -> Ellipse {
    Ellipse { radii: DVec2::splat((ellipse.radii.x * ellipse.radii.y).sqrt()), angle: 0.0 }
}

/// Returns the index `eta + i k` of a metal with the reflectance `f0` (below 1) at normal incidence. `refraction` is from 0 to 1. At 0,
/// `eta` has its smallest value, 1. At 1, `eta` has its largest value, `(1 + √F₀) / (1 − √F₀)`, and `k` is 0.
fn index(f0: DVec3, refraction: f64) -> (DVec3, DVec3) {
    let root = f0.map(f64::sqrt);
    let eta = DVec3::ONE + refraction * (2.0 * root / (DVec3::ONE - root));
    // The equation F₀ ((η + 1)² + k²) = (η − 1)² + k² is solved for k².
    let square = (f0 * (eta + 1.0) * (eta + 1.0) - (eta - 1.0) * (eta - 1.0)) / (DVec3::ONE - f0);
    (eta, square.max(DVec3::ZERO).map(f64::sqrt))
}

/// A simple material that is evaluated in the same way as in its renderer.
struct Reflecting {
    lobes: Vec<(f64, Box<dyn Brdf>)>,
    surface: Surface,
    coat: Coat,
}

impl Brdf for Reflecting {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let specular: DVec3 = self.lobes.iter().map(|(share, lobe)| *share * lobe.eval_cos(wo, wi)).sum();
        self.surface.diffuse(&self.coat, wo, wi) * wi.z.max(0.0) + self.surface.share() * specular
    }
}

impl Facets {
    /// Returns `f_r cos θ_i` of ideal specular facets.
    fn ideal(&self, masking: Masking, s: &Sample) -> f64 {
        match self {
            Self::Ggx(ellipse) => {
                let slopes = Ggx::new(DVec2::ZERO, roughness_from_ellipse(ellipse));
                microfacet_eval(masking, &slopes, s.wo, s.wi)
            }
            Self::Beckmann(lobes) => lobes
                .iter()
                .map(|(share, ellipse)| share * microfacet_eval(masking, &beckmann(ellipse), s.wo, s.wi))
                .sum(),
        }
    }
}

fn beckmann(ellipse: &Ellipse) -> Beckmann {
    Beckmann::new(DVec2::ZERO, 0.5 * roughness_from_ellipse(ellipse))
}

impl fmt::Display for Renderer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mitsuba => "Mitsuba",
            Self::Pbrt => "pbrt",
        })
    }
}

impl Renderer {
    const fn masking(self) -> Masking {
        match self {
            Self::Mitsuba => Masking::SmithSeparable,
            Self::Pbrt => Masking::SmithCorrelated,
        }
    }
}

/// Weighted sums over the samples at one difference angle. The sums give the normal equations of a specular term and a diffuse base.
#[derive(Clone, Copy, Default)]
struct Ring {
    weight: f64,
    cosine: f64,
    specular: f64,
    specular_squared: f64,
    values: DVec3,
    specular_values: DVec3,
}

/// The number of rings of one degree. Sampled difference angles are further apart, so all samples of a ring have the same angle.
const RINGS: usize = 91;

fn ring_of(s: &Sample) -> usize {
    s.wo.dot(s.wh).clamp(0.0, 1.0).acos().to_degrees() as usize
}

/// The samples, and their specular term for a Fresnel term of 1.
struct Lobe<'a> {
    samples: &'a [Sample],
    /// The value of `f_r` of ideal specular facets for each sample.
    specular: Vec<f64>,
    rings: [Ring; RINGS],
}

impl<'a> Lobe<'a> {
    fn new(samples: &'a [Sample], facets: &Facets, renderer: Renderer) -> Self {
        let ideal = |s: &Sample| facets.ideal(renderer.masking(), s) / s.wi.z;
        let specular: Vec<f64> = samples.iter().map(ideal).collect();
        let mut rings = [Ring::default(); RINGS];
        for (s, &ideal) in samples.iter().zip(&specular) {
            let ring = &mut rings[ring_of(s)];
            ring.weight += s.weight;
            ring.cosine += s.weight * s.wo.dot(s.wh);
            ring.specular += s.weight * ideal;
            ring.specular_squared += s.weight * ideal * ideal;
            ring.values += s.weight * s.value;
            ring.specular_values += s.weight * ideal * s.value;
        }
        rings.iter_mut().for_each(|ring| ring.cosine /= ring.weight.max(1e-300));
        Self { samples, specular, rings }
    }

    /// Fits a metal of fraction `share`, and the diffuse base of the remaining fraction. The fit uses alternating least squares, with
    /// Gauss-Newton steps for the metal.
    fn metal(&self, share: f64, refraction: f64) -> Surface {
        const ROUNDS: usize = 60;
        const STEP: f64 = 1e-4;
        let range = (DVec3::splat(0.001), DVec3::splat(MOST - STEP));
        let fresnel = |f0: DVec3, cosine: f64| {
            let (eta, k) = index(f0, refraction);
            share * fresnel_conductor(cosine, eta, k)
        };
        let most = FRAC_1_PI * (1.0 - share) * MOST;
        let (mut f0, mut diffuse) = (DVec3::splat(0.5), DVec3::ZERO);
        for _ in 0..ROUNDS {
            let (mut change, mut curvature, mut rest, mut weight) =
                (DVec3::ZERO, DVec3::splat(1e-30), DVec3::ZERO, 1e-30);
            for ring in &self.rings {
                let now = fresnel(f0, ring.cosine);
                let slope = (fresnel(f0 + STEP, ring.cosine) - now) / STEP;
                change += slope * (ring.specular_values - now * ring.specular_squared - diffuse * ring.specular);
                curvature += slope * slope * ring.specular_squared;
            }
            f0 = (f0 + change / curvature).clamp(range.0, range.1);
            for ring in &self.rings {
                rest += ring.values - fresnel(f0, ring.cosine) * ring.specular;
                weight += ring.weight;
            }
            diffuse = (rest / weight).clamp(DVec3::ZERO, DVec3::splat(most));
        }
        // With a fraction of 1, no diffuse base remains.
        let albedo = if share < 1.0 { diffuse * (PI / (1.0 - share)) } else { DVec3::ZERO };
        let (eta, k) = index(f0, refraction);
        Surface::Metal { share, eta, k, albedo }
    }

    /// Fits the diffuse base under the coat by least squares.
    fn coated(&self, coat: &Coat) -> Surface {
        let (mut product, mut square) = (DVec3::ZERO, 1e-30);
        for (s, &ideal) in self.samples.iter().zip(&self.specular) {
            let window = coat.window(s.wo, s.wi);
            product += s.weight * window * (s.value - ideal * fresnel_dielectric(s.wo.dot(s.wh), COAT_INDEX));
            square += s.weight * window * window;
        }
        Surface::Coated(coat.albedo(product / square))
    }

    /// Returns the squared error of a surface in cube roots. The error is proportional to the square of [`Misfit::perceptual`].
    fn error(&self, surface: &Surface, coat: &Coat) -> f64 {
        let fresnel = self.rings.map(|ring| surface.fresnel().at(ring.cosine));
        let root = |f: DVec3| f.map(f64::cbrt);
        let one = |(s, &ideal): (&Sample, &f64)| {
            let model = surface.share() * ideal * fresnel[ring_of(s)] + surface.diffuse(coat, s.wo, s.wi);
            s.weight * (root(model * s.wi.z) - root(s.value * s.wi.z)).length_squared()
        };
        self.samples.iter().zip(&self.specular).map(one).sum()
    }
}

impl Surface {
    fn fresnel(&self) -> Fresnel {
        match *self {
            Self::Metal { eta, k, .. } => Fresnel::Conductor { eta, k },
            Self::Coated(_) => Fresnel::Dielectric(COAT_INDEX),
        }
    }

    /// Returns the fraction of the surface that has the specular lobe.
    fn share(&self) -> f64 {
        match *self {
            Self::Metal { share, .. } => share,
            Self::Coated(_) => 1.0,
        }
    }

    /// Returns `f_r` of the diffuse base.
    fn diffuse(&self, coat: &Coat, wo: DVec3, wi: DVec3) -> DVec3 {
        match *self {
            Self::Metal { share, albedo, .. } => FRAC_1_PI * (1.0 - share) * albedo,
            Self::Coated(albedo) => coat.strength(albedo) * coat.window(wo, wi),
        }
    }
}

impl Simple {
    /// Returns the material that is nearest to the samples, and its misfit. The material has a GGX lobe of this roughness, or the Gaussian
    /// lobes if there are several.
    pub fn nearest(samples: &[Sample], ellipse: Ellipse, lobes: &[Gaussian], renderer: Renderer) -> (Self, Misfit) {
        let one = Self::of_one_lobe(samples, ellipse, renderer);
        let by = |simple: Self| {
            let wrong = misfit(samples, &simple.reflecting());
            (simple, wrong)
        };
        let one = by(one);
        if lobes.len() < 2 {
            return one;
        }
        let several = by(Self::of_lobes(samples, lobes, renderer));
        if several.1.perceptual < one.1.perceptual { several } else { one }
    }

    /// Returns the nearest metal over a diffuse base, with Gaussian lobes.
    fn of_lobes(samples: &[Sample], lobes: &[Gaussian], renderer: Renderer) -> Self {
        let ellipse = |lobe: &Gaussian| ellipse_from_roughness(2.0 * lobe.covariance);
        let facets = Facets::Beckmann(lobes.iter().map(|lobe| (lobe.share, ellipse(lobe))).collect());
        let surface = nearest_metal(&Lobe::new(samples, &facets, renderer), &coat(&ellipse(&lobes[0]))).1;
        Self { renderer, facets, surface }
    }

    fn of_one_lobe(samples: &[Sample], ellipse: Ellipse, renderer: Renderer) -> Self {
        let coat = coat(&ellipse);
        let best = nearest_metal(&Lobe::new(samples, &Facets::Ggx(ellipse), renderer), &coat);
        // Mitsuba supports only isotropic coats.
        let coat_ellipse = if renderer == Renderer::Mitsuba { rounded(ellipse) } else { ellipse };
        let lobe = Lobe::new(samples, &Facets::Ggx(coat_ellipse), renderer);
        let surface = lobe.coated(&coat);
        if lobe.error(&surface, &coat) < best.0 {
            Self { renderer, facets: Facets::Ggx(coat_ellipse), surface }
        } else {
            Self { renderer, facets: Facets::Ggx(ellipse), surface: best.1 }
        }
    }

    /// Returns the BRDF as its renderer evaluates it.
    fn reflecting(&self) -> Reflecting {
        let (masking, fresnel) = (self.renderer.masking(), self.surface.fresnel());
        let lobes: Vec<(f64, Box<dyn Brdf>)> = match &self.facets {
            Facets::Ggx(ellipse) => {
                let distribution = Ggx::new(DVec2::ZERO, roughness_from_ellipse(ellipse));
                vec![(1.0, Box::new(Microfacet { distribution, masking, fresnel }))]
            }
            Facets::Beckmann(lobes) => lobes
                .iter()
                .map(|(share, ellipse)| {
                    let facets = Microfacet { distribution: beckmann(ellipse), masking, fresnel: fresnel.clone() };
                    (*share, Box::new(facets) as Box<dyn Brdf>)
                })
                .collect(),
        };
        Reflecting { lobes, surface: self.surface, coat: coat(&self.ellipses()[0].1) }
    }

    /// Returns the lobes with their shares.
    fn ellipses(&self) -> Vec<(f64, Ellipse)> {
        match &self.facets {
            Facets::Ggx(ellipse) => vec![(1.0, *ellipse)],
            Facets::Beckmann(lobes) => lobes.clone(),
        }
    }

    /// Returns the material in the scene format of its renderer.
    pub fn text(&self, name: &str) -> String {
        match self.renderer {
            Renderer::Mitsuba => self.mitsuba(name),
            Renderer::Pbrt => self.pbrt(name),
        }
    }

    /// Returns a BSDF for Mitsuba 3. With `nonlinear`, the diffuse base also colours the light that the coat reflects back to the base.
    fn mitsuba(&self, name: &str) -> String {
        let rgb = |name: &str, c: DVec3| format!(r#"<rgb name="{name}" value="{:.6}, {:.6}, {:.6}"/>"#, c.x, c.y, c.z);
        let float = |name: &str, value: f64| format!(r#"<float name="{name}" value="{value:.6}"/>"#);
        let distribution = |name: &str| format!(r#"<string name="distribution" value="{name}"/>"#);
        let element = match self.surface {
            Surface::Coated(albedo) => {
                let nonlinear = r#"<boolean name="nonlinear" value="true"/>"#.to_owned();
                let (inside, outside) = (float("int_ior", COAT_INDEX), float("ext_ior", 1.0));
                let (alpha, diffuse) =
                    (float("alpha", self.ellipses()[0].1.radii.x), rgb("diffuse_reflectance", albedo));
                Element("roughplastic", vec![distribution("ggx"), alpha, inside, outside, nonlinear, diffuse])
            }
            Surface::Metal { share, eta, k, albedo } => {
                let kind = if matches!(self.facets, Facets::Ggx(_)) { "ggx" } else { "beckmann" };
                let metal = |ellipse: &Ellipse| {
                    let (u, v, _) = axes(ellipse);
                    let lines = vec![distribution(kind), float("alpha_u", u), float("alpha_v", v)];
                    Element("roughconductor", [lines, vec![rgb("eta", eta), rgb("k", k)]].concat())
                };
                let blended = |first: Element, second: Element, weight: f64| {
                    Element("blendbsdf", [vec![float("weight", weight)], first.nested(), second.nested()].concat())
                };
                let metals = mixed(&self.ellipses(), metal, blended);
                if share < 1.0 {
                    blended(Element("diffuse", vec![rgb("reflectance", albedo)]), metals, share)
                } else {
                    metals
                }
            }
        };
        let remark =
            self.rotations().map(|by| format!("<!-- alpha_u is rotated by {by} degrees from the tangent -->\n"));
        remark.unwrap_or_default() + &element.root(name)
    }

    /// Returns a named material for pbrt-v4. A coat has a thickness of 0, so it absorbs no light. A mixture refers to two named materials.
    fn pbrt(&self, name: &str) -> String {
        let rgb = |name: &str, c: DVec3| format!(" \"rgb {name}\" [ {:.6} {:.6} {:.6} ]", c.x, c.y, c.z);
        let material = |name: &str, kind: &str| format!("MakeNamedMaterial \"{name}\" \"string type\" \"{kind}\"");
        let lobe = |ellipse: &Ellipse| {
            let (u, v, _) = axes(ellipse);
            format!("\n    \"float uroughness\" {u:.6} \"float vroughness\" {v:.6} \"bool remaproughness\" false\n")
        };
        let mix = |name: &str, first: &str, second: &str, amount: f64| {
            let both = material(name, "mix");
            format!("{both} \"string materials\" [ \"{first}\" \"{second}\" ] \"float amount\" {amount:?}\n")
        };
        let ellipses = self.ellipses();
        let materials = match self.surface {
            Surface::Coated(albedo) => {
                let color = rgb("reflectance", albedo);
                let coat = material(name, "coateddiffuse");
                let lobe = lobe(&ellipses[0].1);
                format!("{coat}{color} \"float eta\" {COAT_INDEX:?} \"float thickness\" 0{lobe}")
            }
            Surface::Metal { share, eta, k, albedo } => {
                let covering = if share < 1.0 { format!("{name}_metal") } else { name.to_owned() };
                let mut lines = String::new();
                if share < 1.0 {
                    lines = material(&format!("{name}_body"), "diffuse") + &rgb("reflectance", albedo) + "\n";
                }
                let numbered = |i: usize| {
                    if ellipses.len() > 1 { format!("{name}_lobe{}", i + 1) } else { covering.clone() }
                };
                for (i, (_, ellipse)) in ellipses.iter().enumerate() {
                    lines += &(material(&numbered(i), "conductor") + &rgb("eta", eta) + &rgb("k", k) + &lobe(ellipse));
                }
                // Lobe by lobe, each covers its share of what the ones before leave.
                let mut before = 0.0;
                for (i, (share, _)) in ellipses.iter().enumerate() {
                    before += share;
                    if i > 0 {
                        let last = i + 1 == ellipses.len();
                        let first = if i == 1 { numbered(0) } else { format!("{name}_lobes{i}") };
                        let both = if last { covering.clone() } else { format!("{name}_lobes{}", i + 1) };
                        lines += &mix(&both, &first, &numbered(i), share / before);
                    }
                }
                if share < 1.0 {
                    lines += &mix(name, &format!("{name}_body"), &covering, share);
                }
                lines
            }
        };
        let remark = self.rotations().map(|by| format!("# uroughness is rotated by {by} degrees from the tangent\n"));
        remark.unwrap_or_default() + &materials
    }

    /// Returns the rotations of all lobes as text, or `None` if the axes of all lobes are the tangent. Neither renderer supports rotations.
    fn rotations(&self) -> Option<String> {
        let all: Vec<Option<f64>> = self.ellipses().iter().map(|(_, ellipse)| axes(ellipse).2).collect();
        let shown = |by: &Option<f64>| format!("{:.2}", by.unwrap_or(0.0));
        all.iter().any(Option::is_some).then(|| all.iter().map(shown).collect::<Vec<_>>().join(", "))
    }
}

/// Returns the metal with the lowest error, and the error.
fn nearest_metal(lobe: &Lobe, coat: &Coat) -> (f64, Surface) {
    let nearer = |a: (f64, Surface), b: (f64, Surface)| if b.0 < a.0 { b } else { a };
    let metal = |share, refraction| {
        let surface = lobe.metal(share, refraction);
        (lobe.error(&surface, coat), surface)
    };
    let [refraction, others @ ..] = REFRACTIONS;
    let best = SHARES.map(|share| metal(share, refraction)).into_iter().reduce(nearer).expect("there are some");
    others.map(|refraction| metal(best.1.share(), refraction)).into_iter().fold(best, nearer)
}

/// Combines lobes by a function of two materials and the weight of the second.
fn mixed<T>(lobes: &[(f64, Ellipse)], of: impl Fn(&Ellipse) -> T, blended: impl Fn(T, T, f64) -> T) -> T {
    let mut all = of(&lobes[0].1);
    let mut before = lobes[0].0;
    for (share, ellipse) in &lobes[1..] {
        before += share;
        all = blended(all, of(ellipse), share / before);
    }
    all
}

/// An element of a scene for Mitsuba: its type and its lines.
struct Element(&'static str, Vec<String>);

impl Element {
    fn indented(&self) -> impl Iterator<Item = String> {
        self.1.iter().map(|line| format!("    {line}"))
    }

    /// Returns the lines of the element inside another one.
    fn nested(&self) -> Vec<String> {
        let first = format!(r#"<bsdf type="{}">"#, self.0);
        match &self.1[..] {
            [line] => vec![format!("{first}{line}</bsdf>")],
            _ => std::iter::once(first).chain(self.indented()).chain(["</bsdf>".to_owned()]).collect(),
        }
    }

    /// Returns the text of the whole file.
    fn root(&self, name: &str) -> String {
        let first = format!(r#"<bsdf version="3.0.0" id="{name}" type="{}">"#, self.0);
        let lines: String = self.indented().map(|line| line + "\n").collect();
        format!("{first}\n{lines}</bsdf>\n")
    }
}

/// Returns `α` along the axis nearest to the tangent, `α` across it, and the counter-clockwise rotation of the axes, from −45 to 45 degrees.
fn axes(ellipse: &Ellipse) -> (f64, f64, Option<f64>) {
    let Ellipse { radii, angle } = *ellipse;
    if is_round(ellipse) {
        return (radii.x, radii.y, None);
    }
    let quarters = (angle / FRAC_PI_2).round();
    let rotation = (angle - quarters * FRAC_PI_2).to_degrees();
    let (u, v) = if quarters.rem_euclid(2.0) == 1.0 { (radii.y, radii.x) } else { (radii.x, radii.y) };
    (u, v, (rotation.abs() >= 0.005).then_some(rotation))
}

/// Returns the isotropic coat with the mean roughness of the ellipse.
fn coat(ellipse: &Ellipse) -> Coat {
    Coat::new((ellipse.radii.x * ellipse.radii.y).sqrt(), COAT_INDEX)
}

/// Converts a file name to an identifier that all renderers accept.
pub fn identifier(stem: &str) -> String {
    let mut name: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(60).collect();
    if name.is_empty() {
        name.push_str("material");
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::extraction::samples::samples;

    fn ellipse(alpha: f64) -> Ellipse {
        Ellipse { radii: DVec2::splat(alpha), angle: 0.0 }
    }

    #[test]
    fn a_metal_is_written_as_a_metal() {
        // The rougher axis is 100° from the tangent, so the smoother axis is closer to the tangent and comes first.
        let long = Ellipse { radii: DVec2::new(0.3, 0.1), angle: 100f64.to_radians() };
        let (eta, k) = index(DVec3::new(0.9, 0.7, 0.4), 0.5);
        for renderer in [Renderer::Mitsuba, Renderer::Pbrt] {
            let metal = Surface::Metal { share: 1.0, eta, k, albedo: DVec3::ZERO };
            let gold = Simple { renderer, facets: Facets::Ggx(long), surface: metal };
            let (found, wrong) = Simple::nearest(&samples(&gold.reflecting(), false), long, &[], renderer);
            let Surface::Metal { share: 1.0, eta: n, k: extinction, .. } = found.surface else { panic!("{found:?}") };
            assert!((n - eta).length() < 1e-3 && (extinction - k).length() < 1e-3 && wrong.rrmse < 1e-6, "{found:?}");
            let text = found.text("gold");
            let words: &[&str] = match renderer {
                Renderer::Mitsuba => {
                    &["type=\"roughconductor\"", "alpha_u\" value=\"0.100000", "alpha_v\" value=\"0.300000"]
                }
                Renderer::Pbrt => {
                    &["\"conductor\" \"rgb eta\" [", "uroughness\" 0.100000 \"float vroughness\" 0.300000"]
                }
            };
            assert!(words.iter().chain(&["rotated by 10.00 degrees"]).all(|word| text.contains(word)), "{text}");
        }
    }

    #[test]
    fn paper_is_written_as_a_mixture() {
        let round = ellipse(0.5);
        for renderer in [Renderer::Mitsuba, Renderer::Pbrt] {
            let (eta, k) = index(DVec3::new(0.5, 0.6, 0.7), 0.5);
            let metal = Surface::Metal { share: 0.2, eta, k, albedo: DVec3::new(0.9, 0.8, 0.5) };
            let paper = Simple { renderer, facets: Facets::Ggx(round), surface: metal };
            let (found, wrong) = Simple::nearest(&samples(&paper.reflecting(), true), round, &[], renderer);
            let Surface::Metal { share: 0.2, albedo, .. } = found.surface else { panic!("{found:?}") };
            assert!((albedo - DVec3::new(0.9, 0.8, 0.5)).length() < 1e-3 && wrong.rrmse < 1e-4, "{found:?} {wrong:?}");
            let text = found.text("a");
            let words: &[&str] = match renderer {
                Renderer::Mitsuba => {
                    &["type=\"blendbsdf\"", "weight\" value=\"0.200000", "<bsdf type=\"diffuse\"><rgb"]
                }
                Renderer::Pbrt => &[
                    "\"string materials\" [ \"a_body\" \"a_metal\" ] \"float amount\" 0.2",
                    "\"a_metal\" \"string type\" \"conductor\"",
                ],
            };
            assert!(words.iter().all(|word| text.contains(word)) && !text.contains("rotated"), "{text}");
            assert_eq!(text.matches("<bsdf").count(), text.matches("</bsdf>").count());
        }
    }

    /// Two lobes of very different width are better than one GGX lobe, and are written with the weights of a chain of mixtures.
    #[test]
    fn lobes_are_written_as_mixtures() {
        let lobe = |share, alpha: f64| Gaussian { share, covariance: 0.5 * alpha * alpha * DVec3::new(1.0, 1.0, 0.0) };
        let lobes = [lobe(0.5, 0.05), lobe(0.3, 0.2), lobe(0.2, 0.6)];
        for renderer in [Renderer::Mitsuba, Renderer::Pbrt] {
            let (eta, k) = index(DVec3::new(0.9, 0.7, 0.4), 0.5);
            let surface = Surface::Metal { share: 0.8, eta, k, albedo: DVec3::splat(0.3) };
            let facets =
                Facets::Beckmann(lobes.iter().map(|l| (l.share, ellipse((2.0 * l.covariance.x).sqrt()))).collect());
            let truth = samples(&Simple { renderer, facets, surface }.reflecting(), true);
            let (found, wrong) = Simple::nearest(&truth, ellipse(0.15), &lobes, renderer);
            let (_, one) = Simple::nearest(&truth, ellipse(0.15), &[], renderer);
            assert!(wrong.perceptual < 1e-3 && one.perceptual > 10.0 * wrong.perceptual, "{wrong:?} {one:?}");
            let text = found.text("a");
            // 0.3/0.8, then 0.2 of all lobes, then 0.8 of all.
            let words: &[&str] = match renderer {
                Renderer::Mitsuba => {
                    &["weight\" value=\"0.375000", "weight\" value=\"0.200000", "weight\" value=\"0.800000", "beckmann"]
                }
                Renderer::Pbrt => &[
                    "\"a_lobes2\" \"string type\" \"mix\" \"string materials\" [ \"a_lobe1\" \"a_lobe2\" ] \"float amount\" 0.37",
                    "[ \"a_lobes2\" \"a_lobe3\" ] \"float amount\" 0.2",
                    "\"a\" \"string type\" \"mix\" \"string materials\" [ \"a_body\" \"a_metal\" ] \"float amount\" 0.8",
                ],
            };
            assert!(words.iter().all(|word| text.contains(word)), "{text}");
            assert_eq!(text.matches("<bsdf").count(), text.matches("</bsdf>").count());
        }
    }

    #[test]
    fn a_varnish_is_written_as_a_coat() {
        let round = ellipse(0.1);
        for renderer in [Renderer::Mitsuba, Renderer::Pbrt] {
            let paint =
                Simple { renderer, facets: Facets::Ggx(round), surface: Surface::Coated(DVec3::new(0.5, 0.2, 0.1)) };
            let (found, wrong) = Simple::nearest(&samples(&paint.reflecting(), true), round, &[], renderer);
            let Surface::Coated(albedo) = found.surface else { panic!("{found:?}") };
            assert!((albedo - DVec3::new(0.5, 0.2, 0.1)).length() < 1e-6 && wrong.rrmse < 1e-6, "{albedo} {wrong:?}");
            let text = found.text("paint");
            let words: &[&str] = match renderer {
                Renderer::Mitsuba => &["roughplastic", "nonlinear\" value=\"true", "\"alpha\" value=\"0.100000\""],
                Renderer::Pbrt => &["coateddiffuse", "\"float thickness\" 0", "\"bool remaproughness\" false"],
            };
            assert!(words.iter().all(|word| text.contains(word)) && !text.contains("rotated"), "{text}");
        }
    }

    #[test]
    fn an_index_has_its_reflectance() {
        let f0 = DVec3::new(0.002, 0.3, 0.998);
        for refraction in REFRACTIONS {
            let (eta, k) = index(f0, refraction);
            assert!((fresnel_conductor(1.0, eta, k) - f0).abs().max_element() < 1e-9, "{refraction}: {eta} {k}");
        }
    }

    #[test]
    fn names_have_letters() {
        assert_eq!(identifier("a b/\"c\""), "a_b__c_");
        assert_eq!(identifier(""), "material");
    }
}
