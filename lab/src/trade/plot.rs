//! The work–precision diagram.

use std::ops::Range;
use std::path::Path;

use plotters::coord::Shift;
use plotters::coord::combinators::WithKeyPoints;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::errors::Measure;
use super::method::Family;
use super::row::Row;
use super::scene::Stage;
use crate::plot::{self, Figure};
use crate::report::figure;

/// Width and height, pixels.
const SIZE: (u32, u32) = (1200, 760);
/// Height of the title and width of the legend.
const TITLE: u32 = 56;
const LEGEND: u32 = 300;
/// Height of a line of the legend.
const LINE: i32 = 30;

const INK: RGBColor = RGBColor(40, 40, 46);
const FAINT: RGBColor = RGBColor(226, 226, 232);
const NOISE: RGBColor = RGBColor(232, 232, 236);

/// Error against cost in one scene and size.
pub struct Diagram {
    title: String,
    name: String,
    measure: Measure,
    series: Vec<Series>,
    /// In the unit of the measure, as all errors.
    noise: f64,
}

/// A family of methods: cost, ms, and error of each.
struct Series {
    family: Family,
    lines: Vec<Vec<(f64, f64)>>,
    /// Of its points, if they are to be written beside them.
    names: Vec<String>,
}

/// What a family looks like.
fn colour(family: Family) -> RGBColor {
    match family {
        Family::Level => RGBColor(0, 0, 0),
        Family::Bdf2 => RGBColor(31, 119, 180),
        Family::Spaced => RGBColor(90, 140, 230),
        Family::Euler => RGBColor(148, 103, 189),
        Family::Tolerance => RGBColor(44, 160, 120),
        Family::Newton => RGBColor(120, 160, 60),
        Family::Double => RGBColor(23, 190, 207),
        Family::Cholesky => RGBColor(140, 110, 75),
        Family::Xpbd => RGBColor(214, 39, 40),
        Family::XpbdTuned => RGBColor(255, 127, 14),
        Family::XpbdDamped => RGBColor(227, 90, 160),
        Family::XpbdEq26 => RGBColor(214, 170, 120),
    }
}

impl Diagram {
    /// Of these rows of a stage. Errors below a tenth of the noise are drawn there.
    pub fn new(stage: &Stage, rows: &[&Row], measure: Measure, noise: f64) -> Self {
        let mut series: Vec<Series> = Vec::new();
        for row in rows {
            let error = measure.of(&row.errors);
            if !(row.ms.is_finite() && error.is_finite()) {
                continue;
            }
            if series.last().is_none_or(|last| last.family != row.family) {
                series.push(Series { family: row.family, lines: Vec::new(), names: Vec::new() });
            }
            if let Some(last) = series.last_mut() {
                last.lines.resize(last.lines.len().max(row.line as usize + 1), Vec::new());
                last.lines[row.line as usize].push((row.ms, measure.scale() * error.max(0.1 * noise)));
                last.names.push(row.method.clone());
            }
        }
        Self {
            title: format!("{}, {} × {} vertices: what accuracy costs", stage.scene.title(), stage.side, stage.side),
            name: format!("{}-{}-{}", stage.scene.name(), stage.side, measure.name()),
            measure,
            series,
            noise: measure.scale() * noise,
        }
    }

    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.series.iter().flat_map(|series| series.lines.iter().flatten().copied())
    }

    /// The range of one coordinate, with room at both ends.
    fn range(&self, coordinate: impl Fn((f64, f64)) -> f64) -> Range<f64> {
        let (low, high) = self
            .points()
            .map(coordinate)
            .fold((f64::MAX, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        if low < high { 0.6 * low..1.6 * high } else { 0.1..10.0 }
    }
}

/// Writes the picture.
///
/// # Errors
/// If a file cannot be written.
pub fn save(diagram: &Diagram, out: &Path) -> Result<(), String> {
    plot::save(diagram, out, &diagram.name)
}

type Error<B> = DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;
type Axis = WithKeyPoints<LogCoord<f64>>;
type Chart<'a, B> = ChartContext<'a, B, Cartesian2d<Axis, Axis>>;

impl Figure for Diagram {
    fn size(&self) -> (u32, u32) {
        SIZE
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), Error<B>> {
        let (title, rest) = area.split_vertically(TITLE);
        let (left, right) = rest.split_horizontally(SIZE.0 - LEGEND);
        title.draw(&Text::new(self.title.clone(), (24, 18), text(26, INK)))?;

        let (cost, mut error) = (self.range(|point| point.0), self.range(|point| point.1));
        // Noise that is far below all errors need not be seen.
        if self.noise > 0.1 * error.start {
            error.start = error.start.min(0.6 * self.noise);
        }
        let axis = |range: &Range<f64>| range.clone().log_scale().with_key_points(ticks(range));
        let mut chart = ChartBuilder::on(&left)
            .margin_left(16)
            .margin_right(16)
            .margin_bottom(8)
            .x_label_area_size(56)
            .y_label_area_size(80)
            .build_cartesian_2d(axis(&cost), axis(&error))?;
        if self.noise > error.start {
            let band = [(cost.start, error.start), (cost.end, self.noise)];
            chart.draw_series([Rectangle::new(band, NOISE.filled())])?;
        }
        chart
            .configure_mesh()
            .bold_line_style(FAINT)
            .light_line_style(TRANSPARENT)
            .axis_style(INK)
            .label_style(text(16, INK))
            .axis_desc_style(text(18, INK))
            .x_desc("time of a frame of 1/60 s on one thread, ms")
            .y_desc(self.measure.title())
            .x_label_formatter(&|value| value.to_string())
            .y_label_formatter(&|value| value.to_string())
            .draw()?;
        // The levels last, on top of the others.
        let (levels, others): (Vec<_>, Vec<_>) = self.series.iter().partition(|series| series.family == Family::Level);
        for series in others.iter().chain(&levels) {
            series.draw(&mut chart)?;
        }
        self.draw_legend(&right)
    }
}

impl Diagram {
    fn draw_legend<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), Error<B>> {
        let label =
            |line: usize, words: &str| Text::new(words.to_string(), (64, 12 + LINE * line as i32), text(17, INK));
        let middle = |line: usize| 21 + LINE * line as i32;
        for (line, series) in self.series.iter().enumerate() {
            let y = middle(line);
            area.draw(&PathElement::new([(16, y), (52, y)], stroke(series.family)))?;
            area.draw(&mark((34, y), series.family))?;
            area.draw(&label(line, series.family.title()))?;
        }
        let line = self.series.len();
        let y = middle(line);
        area.draw(&Rectangle::new([(16, y - 8), (52, y + 8)], NOISE.filled()))?;
        let unit = if matches!(self.measure, Measure::Motion | Measure::Settled) { "mm" } else { "%" };
        area.draw(&label(line, &format!("noise, below {} {unit}", figure(self.noise))))
    }
}

impl Series {
    fn draw<B: DrawingBackend>(&self, chart: &mut Chart<B>) -> Result<(), Error<B>> {
        for line in &self.lines {
            chart.draw_series([PathElement::new(line.clone(), stroke(self.family))])?;
            chart.draw_series(line.iter().map(|&point| mark(point, self.family)))?;
        }
        let points = self.lines.iter().flatten().copied().zip(self.names.iter());
        match self.family {
            Family::Level => chart.draw_series(points.enumerate().map(|(i, (point, name))| {
                // To the left, or, where the level before has about the same error, above and below by turns.
                let level = i > 0 && self.lines[0][i - 1].1 / point.1 < 1.3;
                let (offset, place) = match (level, i % 2) {
                    (false, _) => ((-13, 0), Pos::new(HPos::Right, VPos::Center)),
                    (true, 0) => ((0, -11), Pos::new(HPos::Center, VPos::Bottom)),
                    (true, _) => ((0, 11), Pos::new(HPos::Center, VPos::Top)),
                };
                EmptyElement::at(point) + Text::new(name.clone(), offset, text(17, INK).pos(place))
            }))?,
            // The number of substeps alone.
            Family::Xpbd | Family::XpbdTuned => chart.draw_series(points.map(|(point, name)| {
                let number = name.split(' ').next().unwrap_or_default().to_string();
                let style = text(15, colour(self.family)).pos(Pos::new(HPos::Left, VPos::Bottom));
                EmptyElement::at(point) + Text::new(number, (8, -4), style)
            }))?,
            _ => return Ok(()),
        };
        Ok(())
    }
}

/// The mark of a family: a disc, or for the baseline a triangle.
fn mark<C: Clone + 'static, B: DrawingBackend>(at: C, family: Family) -> DynElement<'static, B, C> {
    let style = colour(family).filled();
    match family {
        Family::Level => Circle::new(at, 8, style).into_dyn(),
        family if family.is_baseline() => TriangleMarker::new(at, 8, style).into_dyn(),
        _ => Circle::new(at, 5, style).into_dyn(),
    }
}

fn stroke(family: Family) -> ShapeStyle {
    let width = if family == Family::Level || family.is_baseline() { 3 } else { 2 };
    colour(family).stroke_width(width)
}

fn text(size: i32, colour: RGBColor) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&colour)
}

/// 1, 2 and 5 times the powers of ten in a range.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let decades = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let all = decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| format!("{digit}e{decade}")));
    // Through decimal digits: so that each is the number it is written as.
    all.filter_map(|number| number.parse().ok()).filter(|tick| range.contains(tick)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(ticks(&(0.04..3.0)), [0.05, 0.1, 0.2, 0.5, 1.0, 2.0]);
        assert_eq!(ticks(&(90.0..600.0)), [100.0, 200.0, 500.0]);
    }
}
