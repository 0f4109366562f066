use glam::*;
use leadr::maps::ray_cast::SpherePixel;
use leadr::reflectance::correlated_masking::*;
use leadr::reflectance::frame::*;
use leadr::reflectance::normal_distribution::*;
use leadr::reflectance::shadowed_reference::Surface;
use leadr::reflectance::shadowed_specular::*;
use leadr::reflectance::slope_grid::*;
use leadr::reflectance::specular::*;
use leadr::reflectance::visible_slopes::*;
use leadr::reflectance::visible_specular::*;
use rayon::prelude::*;

fn environment(d: DVec3, variance: f64) -> f64 {
    let (one, two) = ((-variance).exp(), (-3.0 * variance).exp());
    1.0 + one * d.dot(DVec3::new(0.3, 0.5, 0.2)) + two * (0.2 * d.y * d.z + 0.15 * (d.x * d.x - d.y * d.y))
}
fn lights(d: DVec3, variance: f64) -> f64 {
    let lobe = |k: f64, towards: DVec3| {
        let w = 1.0 + k * variance;
        (k / w * (d.dot(towards.normalize()) - 1.0)).exp() / w
    };
    0.3 * environment(d, variance)
        + 2.0 * lobe(20.0, DVec3::new(0.5, 0.6, 0.6))
        + 1.5 * lobe(60.0, DVec3::new(-0.7, 0.1, 0.3))
}
fn gh(n: usize) -> Vec<(f64, f64)> {
    match n {
        1 => vec![(0.0, 1.0)],
        2 => vec![(-1.0, 0.5), (1.0, 0.5)],
        _ => {
            let r = line_rule(n as u32);
            (0..r.n)
                .map(|i| {
                    let j = f64::from(i) - 0.5 * f64::from(r.n - 1);
                    (j * r.step, r.norm * (-r.decay * j * j).exp())
                })
                .collect()
        }
    }
}
fn product(
    env: &dyn Fn(DVec3, f64) -> f64,
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    (mm, kk, k1, k2, mode): (usize, usize, f64, f64, u32),
    shadow: bool,
) -> f64 {
    let vis = Visibility::Correlated;
    let v = visible_slopes(wo, m, s);
    let ch = slope_cholesky(v.s);
    let o = direction_area(wo, v.m, ch);
    let p = if o.spread > 1e-9 { o.whitened / o.spread } else { DVec2::X };
    let cm = |q: DVec2| DVec2::new(ch.x * q.x, ch.y * q.x + ch.z * q.y);
    let (axis, e) = (cm(p), cm(DVec2::new(-p.y, p.x)));
    let sd = v.variance.sqrt();
    let skew = v.third / (6.0 * v.variance * sd);
    let ao = o.meso.max(0.0);
    let mut sum = 0.0;
    for (z, w) in gh(mm) {
        let at = |z: f64| v.mean + axis * (sd * (z + skew * (z * z - 1.0)));
        let zf = z * (1.0 - k1).sqrt();
        let x = at(if mode & 1 == 0 { z } else { zf });
        let f = (wo.z - wo.xy().dot(x)).max(0.0);
        let iv = if shadow {
            positive_interval(
                -ao * e.length_squared(),
                2.0 * (f * e.dot(v.m) - ao * x.dot(e)),
                2.0 * f * (1.0 + x.dot(v.m)) - ao * (1.0 + x.length_squared()),
            )
        } else {
            DVec2::new(-8.0, 8.0)
        };
        if iv.x >= iv.y {
            continue;
        }
        let (pl, ph) = (normal_pdf(iv.x), normal_pdf(iv.y));
        let mass = (normal_cdf(iv.y) - normal_cdf(iv.x)).max(1e-9);
        let mu = ((pl - ph) / mass).clamp(iv.x, iv.y);
        let sy = (1.0 + (iv.x * pl - iv.y * ph) / mass - mu * mu).clamp(0.0, 1.0).sqrt();
        for (y, wy) in gh(kk) {
            let ys = mu + y * sy;
            let g = if shadow {
                let wi = environment_sample_at(wo, x + ys * e).wi;
                lit_fraction(vis, &o, &direction_area(wi, v.m, ch))
            } else {
                1.0
            };
            let xf = at(zf) + (mu + y * sy * (1.0 - k2).sqrt()) * e;
            let smp = environment_sample_at(wo, xf);
            let jac = 4.0 * reflection_jacobian(wo.z - wo.xy().dot(xf), 1.0 + xf.length_squared());
            let area = jac * axis.perp_dot(e).abs() * sd * sy * (k1 * k2).sqrt();
            sum += w * wy * mass * g * env(smp.wi, area);
        }
    }
    sum
}

fn line2(env: &dyn Fn(DVec3, f64) -> f64, wo: DVec3, m: DVec2, s: DVec3, n: u32, mode: u32) -> f64 {
    let vis = Visibility::Correlated;
    let v = visible_slopes(wo, m, s);
    let ch = slope_cholesky(v.s);
    let o = direction_area(wo, v.m, ch);
    let rule = line_rule(n);
    let line = visible_line(wo, m, s, 1.0, &rule);
    let p = if o.spread > 1e-9 { o.whitened / o.spread } else { DVec2::X };
    let cm = |q: DVec2| DVec2::new(ch.x * q.x, ch.y * q.x + ch.z * q.y);
    let (axis, e) = (cm(p), cm(DVec2::new(-p.y, p.x)));
    let sd = v.variance.sqrt();
    let skew = v.third / (6.0 * v.variance * sd);
    let ao = o.meso.max(0.0);
    let x = line.major.x / ch.x.max(1e-9);
    let q = DVec2::new(x, (line.major.y - ch.y * x) / ch.z.max(1e-9));
    let dir = DVec2::new(p.dot(q) / sd, p.x * q.y - p.y * q.x).try_normalize().unwrap_or(DVec2::X);
    let (mut c, mut t1, mut t2, mut n1) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    let (mut zz2, mut m1) = (0.0, DVec2::ZERO);
    for (z, w) in gh(7) {
        let u = z + skew * (z * z - 1.0);
        let x = v.mean + axis * (sd * u);
        let f = (wo.z - wo.xy().dot(x)).max(0.0);
        let iv = positive_interval(
            -ao * e.length_squared(),
            2.0 * (f * e.dot(v.m) - ao * x.dot(e)),
            2.0 * f * (1.0 + x.dot(v.m)) - ao * (1.0 + x.length_squared()),
        );
        if iv.x >= iv.y {
            continue;
        }
        let (pl, ph) = (normal_pdf(iv.x), normal_pdf(iv.y));
        let mass = (normal_cdf(iv.y) - normal_cdf(iv.x)).max(1e-9);
        let mu = ((pl - ph) / mass).clamp(iv.x, iv.y);
        let sy = (1.0 + (iv.x * pl - iv.y * ph) / mass - mu * mu).clamp(0.0, 1.0).sqrt();
        for y in [mu - sy, mu + sy] {
            let wi = environment_sample_at(wo, x + y * e).wi;
            let g = 0.5 * w * mass * lit_fraction(vis, &o, &direction_area(wi, v.m, ch));
            let zz = dir.dot(DVec2::new(u, y));
            let t = dir.perp_dot(DVec2::new(u, y));
            c += g * DVec3::new(1.0, zz, 0.5 * (zz * zz - 1.0));
            n1 += g * t;
            t2 += g * t * t;
            zz2 += g * zz * zz;
            m1 += g * DVec2::new(u, y);
        }
    }
    let _ = &mut t1;
    let c0 = c.x.max(1e-9);
    let (tb, tv) = (n1 / c0, (t2 / c0 - (n1 / c0).powi(2)).clamp(0.02, 1.5));
    let (zb, zv) = (c.y / c0, (zz2 / c0 - (c.y / c0).powi(2)).clamp(0.02, 1.5));
    let (mut sum, mut tot) = (0.0, 0.0);
    for i in 0..rule.n {
        let z = (f64::from(i) - 0.5 * f64::from(rule.n - 1)) * rule.step;
        // parallel axis t: minor direction of unit t: slope for (u,y) = perp
        let minor = axis * (sd * -dir.y) + e * dir.x;
        let pr = visible_probe(&line, wo, i, &rule);
        let sl = pr.slope;
        let (slope, w, var) = match mode {
            0 => (sl, pr.weight * (c.x + c.y * z + c.z * (z * z - 1.0)).max(0.0), 1.0),
            1 => (sl, pr.weight * (c.x + c.y * z + c.z * (z * z - 1.0)).max(0.0), tv),
            2 => (sl + tb * minor, pr.weight * (c.x + c.y * z + c.z * (z * z - 1.0)).max(0.0), tv),
            // the lit Gaussian itself: probes moved and scaled
            3 | 4 => {
                let full = axis * (sd * dir.x) + e * dir.y;
                // kept part of the line, by length
                let zl = zb + zv.sqrt() * z;
                let centre = v.mean + full * zb + minor * tb;
                let _ = zl;
                (centre + line.major * (zv.sqrt() * z), pr.weight * c0, if mode == 3 { tv } else { (tv * zv).sqrt() })
            }
            _ => (sl, 0.0, 1.0),
        };
        let smp = environment_sample_at(wo, slope);
        let jac = 4.0 * reflection_jacobian(wo.z - wo.xy().dot(slope), 1.0 + slope.length_squared());
        let lod = line.lod + 0.5 * jac.max(1e-12).log2();
        sum += w * env(smp.wi, (2.0 * (lod - LOD_OF_DEVIATION)).exp2() * var);
        tot += w;
    }
    sum * c.x / tot.max(1e-9)
}
const P: [(usize, usize, f64, f64, u32); 10] = [
    (3, 3, 0.25, 0.25, 0),
    (3, 3, 0.25, 0.25, 1),
    (5, 2, 0.15, 0.35, 0),
    (5, 2, 0.15, 0.35, 1),
    (5, 3, 0.15, 0.25, 0),
    (5, 3, 0.15, 0.25, 1),
    (5, 3, 0.08, 0.12, 1),
    (7, 3, 0.09, 0.25, 0),
    (5, 5, 0.15, 0.15, 0),
    (5, 5, 0.08, 0.08, 1),
];
fn main() {
    let surfs = [
        ("g025", 0.0, 0.0, 0.0625, 0.0625, 0.0),
        ("g05", 0., 0., 0.25, 0.25, 0.),
        ("g1", 0., 0., 1., 1., 0.),
        ("g15", 0., 0., 2.25, 2.25, 0.),
        ("an28", 0., 0., 0.04, 0.64, 0.),
        ("an125", 0., 0., 1., 0.0625, 0.),
        ("an4", 0., 0., 0.16, 0.0025, 0.),
        ("cor", -0.3, 0.2, 0.49, 0.25, 0.21),
    ];
    for (name, mx, my, a, b, c) in surfs {
        let su = Surface { m: DVec2::new(mx, my), s: DVec3::new(a, b, c) };
        let rows: Vec<(f64, f64, Vec<f64>)> = (0..24 * 24u32)
            .into_par_iter()
            .filter_map(|i| {
                let px = SpherePixel::new(i % 24, i / 24, 24, 0.97)?;
                let wo = px.wo;
                if leadr::reflectance::projected_area::meso_area(wo, su.m) < 0.03 {
                    return None;
                }
                let at = |d: DVec3, v: f64| lights(from_frame(&px.frame, d), v);
                let w = su.specular_environment(wo, 12, |d| at(d, 0.0));
                let mut g = vec![];
                for n in [5, 9] {
                    for vis in [Visibility::Masking, Visibility::Correlated] {
                        g.push(
                            shadowed_specular_environment(
                                vis,
                                wo,
                                su.m,
                                su.s,
                                1.0,
                                &line_rule(n),
                                &line_rule(7),
                                |p| DVec3::splat(at(p.wi, (2.0 * (p.lod - LOD_OF_DEVIATION)).exp2())),
                            )
                            .x,
                        );
                    }
                }
                for n in [3, 5, 9] {
                    for mode in 0..5 {
                        g.push(0.0);
                        g.push(line2(&at, wo, su.m, su.s, n, mode));
                    }
                }
                for n in [5u32, 9] {
                    let la = grid_lambda(n);
                    let sp = grid_spacing(n, la);
                    g.push(
                        leadr_specular_environment(wo, su.m, su.s, DVec3::ONE, false, n, la, |e| {
                            let l = env_lod(wo, e.wn, su.s, sp, 1.0, LOD_MATCHED);
                            DVec3::splat(at(e.wi, (2.0 * (l - LOD_OF_DEVIATION)).exp2()))
                        })
                        .x,
                    );
                    g.push(0.0);
                }
                Some((w.x, w.z, g))
            })
            .collect();
        let n = rows.len() as f64;
        let (mm, ms) = (rows.iter().map(|r| r.0).sum::<f64>() / n, rows.iter().map(|r| r.1).sum::<f64>() / n);
        print!("{name:6}");
        for k in 0..rows[0].2.len() {
            let e = if k % 2 == 0 {
                (rows.iter().map(|r| (r.2[k] - r.0).powi(2)).sum::<f64>() / n).sqrt() / mm
            } else {
                (rows.iter().map(|r| (r.2[k] - r.1).powi(2)).sum::<f64>() / n).sqrt() / ms
            };
            if e < 1.0 {
                print!(" {}{:5.1}", if k == 4 || k == 14 || k == 24 { "| " } else { "" }, 100.0 * e);
            }
        }
        println!();
    }
}
