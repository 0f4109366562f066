//! Line plots as SVG in the colours of the page.

use std::fmt::Write;

use super::text::{escape, number};

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 380.0;
const LEFT: f64 = 68.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 46.0;
/// The number of colours in the page's style. Further lines repeat the colours and are dashed.
const COLOURS: usize = 10;

/// The scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// A linear axis.
    Linear,
    /// A logarithmic axis, which cannot show values that are zero or negative.
    Log,
}

/// A line of the plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// The name in the legend.
    pub name: String,
    /// The points in drawing order.
    pub points: Vec<(f64, f64)>,
    /// Whether the line is thin, dashed and without points, which marks expected instead of measured values.
    pub guide: bool,
}

/// A plot of lines over two axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// The title of the plot.
    pub title: String,
    x: (String, Scale),
    y: (String, Scale),
    /// The lines.
    pub series: Vec<Series>,
}

/// Maps values of one axis to pixels.
struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// Creates an axis from pixel `from` to pixel `to`, over all `values` that it can show, with a margin.
    fn new(scale: Scale, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let shown = values.filter(|&v| v.is_finite() && (scale == Scale::Linear || v > 0.0));
        let (mut low, mut high) = shown.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
        if low > high {
            (low, high) = (1.0, 10.0);
        }
        match scale {
            Scale::Linear => {
                // The axis includes zero if zero is close to the range.
                if low > 0.0 && low < 0.4 * high {
                    low = 0.0;
                }
                if high <= low {
                    high = low + if low == 0.0 { 1.0 } else { low.abs() * 0.1 };
                }
            }
            Scale::Log => {
                let room = (high / low).powf(0.04).max(1.05);
                (low, high) = (low / room, high * room);
            }
        }
        Self { scale, low, high, from, to }
    }

    /// Returns the pixel of a value, or `None` if the axis cannot show it.
    fn at(&self, value: f64) -> Option<f64> {
        let share = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log if value <= 0.0 => return None,
            Scale::Log => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        share.is_finite().then_some(self.from + share * (self.to - self.from))
    }

    /// Returns the values and labels of the ticks.
    fn ticks(&self) -> Vec<(f64, String)> {
        let decades = (self.high / self.low).log10();
        match self.scale {
            Scale::Linear => self.even_ticks(),
            // The range is too short for ticks at powers of ten.
            Scale::Log if decades < 0.5 => self.even_ticks(),
            Scale::Log => {
                let marks: &[f64] = match decades {
                    _ if decades > 4.0 => &[1.0],
                    _ if decades > 1.5 => &[1.0, 3.0],
                    _ => &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
                };
                let every = (decades / 8.0).ceil().max(1.0) as i32;
                let first = self.low.log10().floor() as i32;
                (first..=self.high.log10().ceil() as i32)
                    .filter(|k| k.rem_euclid(every) == 0)
                    .flat_map(|k| marks.iter().map(move |m| m * 10f64.powi(k)))
                    .filter(|v| (self.low..=self.high).contains(v))
                    .map(|v| (v, tick_label(v)))
                    .collect()
            }
        }
    }

    /// Returns ticks at equal steps of 1, 2 or 5 times a power of ten.
    fn even_ticks(&self) -> Vec<(f64, String)> {
        let rough = (self.high - self.low) / 6.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&s| s >= rough);
        let step = step.unwrap_or(10.0 * power);
        let digits = (-step.log10().floor()).max(0.0) as usize;
        let first = (self.low / step).ceil() as i64;
        let ticks = (first..first + 12).map(|i| i as f64 * step).take_while(|&v| v <= self.high * (1.0 + 1e-9));
        ticks.map(|v| (v, format!("{v:.digits$}"))).collect()
    }
}

/// Formats a round number without needless zeros: `0.003`, `1`, `30`, `1e-5`.
fn tick_label(value: f64) -> String {
    if (1e-3..1e5).contains(&value) {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.0e}")
    }
}

impl Plot {
    /// Creates a plot without lines. Each axis has a label and a scale.
    pub fn new(title: &str, x: (&str, Scale), y: (&str, Scale)) -> Self {
        let axis = |(label, scale): (&str, Scale)| (label.to_owned(), scale);
        Self { title: title.to_owned(), x: axis(x), y: axis(y), series: Vec::new() }
    }

    /// Adds a measured line.
    pub fn line(&mut self, name: &str, points: Vec<(f64, f64)>) {
        self.series.push(Series { name: name.to_owned(), points, guide: false });
    }

    /// Adds a line of expected values.
    pub fn guide(&mut self, name: &str, points: Vec<(f64, f64)>) {
        self.series.push(Series { name: name.to_owned(), points, guide: true });
    }

    /// Returns the SVG element. Points that an axis cannot show (NaN, infinite, or not positive on a logarithmic axis) interrupt
    /// their line.
    pub fn svg(&self) -> String {
        // The height of the legend depends on the lengths of the names.
        let (legend, legend_height) = self.legend();
        let height = HEIGHT + legend_height;
        let values = |pick: fn(&(f64, f64)) -> f64| self.series.iter().flat_map(|s| s.points.iter()).map(pick);
        let x = Axis::new(self.x.1, values(|p| p.0), LEFT, WIDTH - RIGHT);
        let y = Axis::new(self.y.1, values(|p| p.1), HEIGHT - BOTTOM, TOP);
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        let (middle, centre) = ((LEFT + right) / 2.0, (TOP + bottom) / 2.0);
        let title = escape(&self.title);
        let mut svg = format!("<svg viewBox=\"0 0 {WIDTH} {height}\" role=\"img\">\n<title>{title}</title>\n");
        let _ = writeln!(svg, r#"<text class="title" x="{LEFT}" y="18">{title}</text>"#);
        for (value, label) in x.ticks() {
            let Some(at) = x.at(value) else { continue };
            let under = bottom + 15.0;
            let _ = writeln!(svg, r#"<path class="grid" d="M{at:.1} {TOP}V{bottom}"/>"#);
            let _ =
                writeln!(svg, r#"<text class="tick" x="{at:.1}" y="{under:.1}" text-anchor="middle">{label}</text>"#);
        }
        for (value, label) in y.ticks() {
            let Some(at) = y.at(value) else { continue };
            let (beside, base) = (LEFT - 6.0, at + 4.0);
            let _ = writeln!(svg, r#"<path class="grid" d="M{LEFT} {at:.1}H{right}"/>"#);
            let _ =
                writeln!(svg, r#"<text class="tick" x="{beside:.1}" y="{base:.1}" text-anchor="end">{label}</text>"#);
        }
        let (width, height, under) = (right - LEFT, bottom - TOP, bottom + 34.0);
        let _ = writeln!(svg, r#"<rect class="frame" x="{LEFT}" y="{TOP}" width="{width}" height="{height}"/>"#);
        let (x_label, y_label) = (escape(&self.x.0), escape(&self.y.0));
        let _ = writeln!(svg, r#"<text x="{middle}" y="{under}" text-anchor="middle">{x_label}</text>"#);
        let position = format!("translate(14 {centre}) rotate(-90)");
        let _ = writeln!(svg, r#"<text transform="{position}" text-anchor="middle">{y_label}</text>"#);
        for (index, series) in self.series.iter().enumerate() {
            draw(&mut svg, series, index, &x, &y);
        }
        svg.push_str(&legend);
        svg.push_str("</svg>");
        svg
    }

    /// Returns the legend under the plot, and its height.
    fn legend(&self) -> (String, f64) {
        let (mut legend, mut at, mut row) = (String::new(), LEFT, 0.0);
        for (index, series) in self.series.iter().enumerate() {
            // A character of a 12 px font is about 6.6 px wide.
            let width = 44.0 + 6.6 * series.name.chars().count() as f64;
            if at + width > WIDTH && at > LEFT {
                (at, row) = (LEFT, row + 18.0);
            }
            let (y, text, base) = (HEIGHT + row + 4.0, at + 30.0, HEIGHT + row + 4.0 + 4.0);
            let (stroke, name) = (stroke(series, index), escape(&series.name));
            let _ = write!(legend, r#"<path class="series" {stroke} d="M{at:.1} {y}h24"/>"#);
            let _ = writeln!(legend, r#"<text x="{text:.1}" y="{base}">{name}</text>"#);
            at += width;
        }
        (legend, if self.series.is_empty() { 0.0 } else { row + 18.0 })
    }
}

fn stroke(series: &Series, index: usize) -> String {
    if series.guide {
        return "style=\"stroke: var(--faint); stroke-width: 1; stroke-dasharray: 3 4\"".to_owned();
    }
    let dash = match index / COLOURS {
        0 => "",
        1 => "; stroke-dasharray: 7 4",
        _ => "; stroke-dasharray: 2 3",
    };
    format!("style=\"stroke: var(--s{}){dash}\"", index % COLOURS)
}

fn draw(svg: &mut String, series: &Series, index: usize, x: &Axis, y: &Axis) {
    let position = |&(px, py): &(f64, f64)| Some((x.at(px)?, y.at(py)?));
    let mut path = String::new();
    let mut pen_down = false;
    for point in &series.points {
        match position(point) {
            Some((px, py)) => {
                let _ = write!(path, "{}{px:.1} {py:.1}", if pen_down { "L" } else { "M" });
                pen_down = true;
            }
            None => pen_down = false,
        }
    }
    if path.is_empty() {
        return;
    }
    let _ = writeln!(svg, "<path class=\"series\" {} d=\"{path}\"/>", stroke(series, index));
    // Dots have tooltips with the values, but too many dots would hide the line itself.
    if series.guide || series.points.len() > 40 {
        return;
    }
    let colour = index % COLOURS;
    for point in &series.points {
        if let Some((px, py)) = position(point) {
            let label = escape(&format!("{}: {}, {}", series.name, number(point.0), number(point.1)));
            let fill = format!("fill: var(--s{colour})");
            let _ = write!(svg, r#"<circle cx="{px:.1}" cy="{py:.1}" r="3" style="{fill}">"#);
            let _ = writeln!(svg, "<title>{label}</title></circle>");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::well_formed::well_formed;
    use super::*;

    #[test]
    fn axes_map_their_ends_and_middles() {
        let linear = Axis::new(Scale::Linear, [2.0, 10.0, f64::NAN].into_iter(), 100.0, 500.0);
        assert_eq!((linear.at(0.0), linear.at(10.0), linear.at(5.0)), (Some(100.0), Some(500.0), Some(300.0)));
        let log = Axis::new(Scale::Log, [1.0, 100.0, 0.0, -3.0].into_iter(), 300.0, 0.0);
        let (low, middle, high) = (log.at(1.0).unwrap(), log.at(10.0).unwrap(), log.at(100.0).unwrap());
        assert!((middle - 150.0).abs() < 1e-9 && low < 300.0 && high > 0.0 && low > middle && middle > high);
        assert_eq!((log.at(0.0), log.at(-1.0), log.at(f64::NAN)), (None, None, None));
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let labels = |axis: &Axis| axis.ticks().into_iter().map(|(_, label)| label).collect::<Vec<_>>().join(" ");
        let axis = |scale, values: &[f64]| Axis::new(scale, values.iter().copied(), 0.0, 1.0);
        assert_eq!(labels(&axis(Scale::Linear, &[0.0, 1.0])), "0.0 0.2 0.4 0.6 0.8 1.0");
        assert_eq!(labels(&axis(Scale::Linear, &[-20.0, 37.0])), "-20 -10 0 10 20 30");
        assert_eq!(labels(&axis(Scale::Log, &[1.0, 1000.0])), "1 3 10 30 100 300 1000");
        assert_eq!(labels(&axis(Scale::Log, &[1e-6, 0.1])), "1e-6 1e-5 1e-4 0.001 0.01 0.1");
        assert_eq!(labels(&axis(Scale::Log, &[0.43, 0.57])), "0.45 0.50 0.55");
        // Degenerate data must still give an axis.
        for values in [&[][..], &[0.0], &[5.0, 5.0], &[f64::NAN]] {
            for scale in [Scale::Linear, Scale::Log] {
                let axis = axis(scale, values);
                assert!(axis.high > axis.low && axis.ticks().len() < 20, "{values:?}");
                assert!(
                    axis.ticks().iter().all(|(v, _)| axis.at(*v).is_some_and(|p| (-1e-9..=1.0 + 1e-9).contains(&p)))
                );
            }
        }
    }

    #[test]
    fn lines_break_at_undrawable_points() {
        let mut plot = Plot::new("error", ("samples", Scale::Log), ("rRMSE", Scale::Log));
        plot.line("a", vec![(1.0, 0.1), (4.0, 0.05), (16.0, f64::NAN), (64.0, 0.01), (256.0, 0.005)]);
        plot.line("nothing", vec![(1.0, 0.0)]);
        plot.guide("n^-1/2", vec![(1.0, 0.1), (256.0, 0.1 / 16.0)]);
        let svg = plot.svg();
        well_formed(&svg).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let line = svg.lines().find(|l| l.starts_with("<path class=\"series\" style=\"stroke: var(--s0)")).unwrap();
        assert_eq!((line.matches('M').count(), line.matches('L').count()), (2, 2), "{line}");
        // The measured line has four dots, and the guide has none.
        assert_eq!(svg.matches("<circle").count(), 4);
        assert!(svg.contains(">nothing</text>"), "the legend names what has no points");
    }
}
