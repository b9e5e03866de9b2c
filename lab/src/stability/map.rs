//! How each time step and stiffness fares, from each start, as a picture.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::sample::Start;
use super::survey::{Cell, DT_DECADES, Run, STIFFNESS_DECADES};
use super::trial::Outcome;
use crate::plot::Figure;

/// Side of a cell, pixels.
const CELL: i32 = 26;
/// Cells along either side of a panel.
const ACROSS: i32 = DT_DECADES.len() as i32;
const UP: i32 = STIFFNESS_DECADES.len() as i32;
/// Panels beside each other.
const COLUMNS: i32 = 3;
/// From the left edge of a panel to that of the next, and down.
const PITCH: [i32; 2] = [CELL * ACROSS + 96, CELL * UP + 92];
/// Upper left corner of the first panel.
const ORIGIN: [i32; 2] = [104, 112];
/// Where the legend is, from the lower edge of the picture.
const LEGEND: i32 = 50;

/// Share of fallbacks: none, few, all.
const SHADES: [RGBColor; 4] =
    [RGBColor(236, 241, 246), RGBColor(158, 202, 225), RGBColor(49, 130, 189), RGBColor(8, 48, 107)];
const INK: RGBColor = RGBColor(40, 40, 40);
const FAINT: RGBColor = RGBColor(110, 110, 110);

/// The map.
pub struct Map {
    /// By start, time step and stiffness.
    cells: Vec<Summary>,
}

/// What became of the runs of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Summary {
    worst: Outcome,
    substeps: u32,
    fallbacks: u32,
}

impl Map {
    /// Of the runs that belong to it.
    pub fn new(runs: &[Run]) -> Self {
        let mut cells = vec![Summary::default(); Start::HARDEST.len() * DT_DECADES.len() * STIFFNESS_DECADES.len()];
        for Run { plan, verdict } in runs {
            if let Some(cell) = plan.cell {
                let summary = &mut cells[place(cell)];
                summary.worst = summary.worst.max(verdict.outcome);
                summary.substeps += verdict.substeps;
                summary.fallbacks += verdict.fallbacks;
            }
        }
        Self { cells }
    }
}

fn place(cell: Cell) -> usize {
    (cell.start * DT_DECADES.len() + cell.dt) * STIFFNESS_DECADES.len() + cell.stiffness
}

impl Summary {
    fn colour(self) -> RGBColor {
        colour_of(self.worst).unwrap_or_else(|| shade(f64::from(self.fallbacks) / f64::from(self.substeps.max(1))))
    }
}

/// Of what is wrong.
fn colour_of(outcome: Outcome) -> Option<RGBColor> {
    match outcome {
        Outcome::Ok => None,
        Outcome::Frozen => Some(RGBColor(253, 174, 51)),
        Outcome::GainedEnergy => Some(RGBColor(215, 48, 39)),
        Outcome::NonFinite => Some(RGBColor(20, 20, 20)),
        Outcome::Panic => Some(RGBColor(158, 42, 170)),
    }
}

/// Of a share of fallbacks. Few are told apart better than many.
fn shade(share: f64) -> RGBColor {
    let along = share.clamp(0.0, 1.0).sqrt() * (SHADES.len() - 1) as f64;
    let lower = (along as usize).min(SHADES.len() - 2);
    let (a, b, t) = (SHADES[lower], SHADES[lower + 1], along - lower as f64);
    let mix = |a: u8, b: u8| (f64::from(a) + t * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

impl Figure for Map {
    fn size(&self) -> (u32, u32) {
        let rows = (Start::NAMES.len() as i32).div_euclid(COLUMNS);
        ((ORIGIN[0] + COLUMNS * PITCH[0] - 56) as u32, (ORIGIN[1] + rows * PITCH[1] + LEGEND + 6) as u32)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<B> {
        text(area, "Does it hold? A sheet hung by two corners, undamped, at the extremes", [30, 20], 26, HPos::Left)?;
        let about = "Worst outcome of the runs of each time step and stiffness, from the hardest start of each kind; \
                     where all are right, the share of steps that the energy safeguard took again";
        text(area, about, [30, 54], 15, HPos::Left)?;
        let titles = [
            "from rest",
            "crumpled by its own size",
            "collapsed to a point",
            "collapsed to a line",
            "inverted: every other row backwards",
            "stretched a hundredfold",
        ];
        for (start, title) in titles.into_iter().enumerate() {
            let (column, row) = (start as i32 % COLUMNS, start as i32 / COLUMNS);
            self.panel(area, start, title, [ORIGIN[0] + column * PITCH[0], ORIGIN[1] + row * PITCH[1]])?;
        }
        legend(area, [ORIGIN[0], self.size().1 as i32 - LEGEND])
    }
}

impl Map {
    fn panel<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        start: usize,
        title: &str,
        [x, y]: [i32; 2],
    ) -> Drawn<B> {
        text(area, title, [x, y - 24], 17, HPos::Left)?;
        for dt in 0..DT_DECADES.len() {
            for stiffness in 0..STIFFNESS_DECADES.len() {
                let colour = self.cells[place(Cell { start, dt, stiffness })].colour();
                let corner = (x + CELL * dt as i32, y + CELL * (UP - 1 - stiffness as i32));
                square(area, corner, CELL - 1, colour)?;
            }
        }
        for (dt, label) in [(0, "1 ms"), (4, "10 ms"), (8, "0.1 s"), (12, "1 s")] {
            let centre = x + CELL * dt + CELL / 2;
            area.draw(&PathElement::new([(centre, y + CELL * UP), (centre, y + CELL * UP + 4)], INK))?;
            text(area, label, [centre, y + CELL * UP + 8], 14, HPos::Center)?;
        }
        for (stiffness, label) in [(0, "1 mN/m"), (3, "1 N/m"), (6, "1 kN/m"), (9, "1 MN/m"), (12, "1 GN/m")] {
            let middle = y + CELL * (UP - 1 - stiffness) + CELL / 2;
            area.draw(&PathElement::new([(x - 5, middle), (x - 1, middle)], INK))?;
            text(area, label, [x - 8, middle - 8], 14, HPos::Right)?;
        }
        text(area, "time step", [x + CELL * ACROSS / 2, y + CELL * UP + 28], 14, HPos::Center)?;
        let upright = TextStyle::from(("sans-serif", 14).into_font().transform(FontTransform::Rotate270)).color(&INK);
        let upright = upright.pos(Pos::new(HPos::Center, VPos::Center));
        area.draw_text("stiffness", &upright, (x - 70, y + CELL * UP / 2))
    }
}

fn legend<B: DrawingBackend>(area: &DrawingArea<B, Shift>, [x, y]: [i32; 2]) -> Drawn<B> {
    const LENGTH: i32 = 240;
    text(area, "steps taken again", [x, y + 2], 15, HPos::Left)?;
    let left = x + 132;
    for i in 0..LENGTH {
        let colour = shade(f64::from(i) / f64::from(LENGTH - 1));
        area.draw(&PathElement::new([(left + i, y), (left + i, y + 20)], colour))?;
    }
    for (share, label) in [(0, "0"), (25, "25 %"), (50, "50 %"), (100, "100 %")] {
        text(area, label, [left + LENGTH * share / 100, y + 23], 13, HPos::Center)?;
    }
    let mut left = left + LENGTH + 60;
    let wrong = [
        (Outcome::Frozen, "frozen or rejected", 165),
        (Outcome::GainedEnergy, "gained energy", 140),
        (Outcome::NonFinite, "not finite", 110),
        (Outcome::Panic, "panic", 60),
    ];
    for (outcome, label, width) in wrong {
        square(area, (left, y), 20, colour_of(outcome).unwrap_or(WHITE))?;
        text(area, label, [left + 27, y + 2], 15, HPos::Left)?;
        left += width + 27;
    }
    Ok(())
}

fn square<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    (x, y): (i32, i32),
    side: i32,
    colour: RGBColor,
) -> Drawn<B> {
    area.draw(&Rectangle::new([(x, y), (x + side, y + side)], colour.filled()))
}

fn text<B: DrawingBackend>(area: &DrawingArea<B, Shift>, text: &str, [x, y]: [i32; 2], size: u32, h: HPos) -> Drawn<B> {
    let colour = if size == 15 { FAINT } else { INK };
    let style = TextStyle::from(("sans-serif", size).into_font()).color(&colour).pos(Pos::new(h, VPos::Top));
    area.draw_text(text, &style, (x, y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::survey::Survey;
    use crate::stability::trial::Verdict;

    #[test]
    fn a_cell_shows_its_worst_run_else_its_fallbacks() {
        let survey = Survey { seed: 1, cell_runs: 2, random_runs: 1 };
        let verdicts = [
            Verdict { substeps: 10, fallbacks: 10, ..Default::default() },
            Verdict { substeps: 10, fallbacks: 0, outcome: Outcome::Frozen, ..Default::default() },
        ];
        let run = |index: u64, verdict: &Verdict| {
            let plan = survey.describe(index).expect("a run");
            Run { plan, verdict: verdict.clone() }
        };
        // The first cell has one run of either kind, the second two of the first; the last run is of no cell.
        let runs =
            [run(0, &verdicts[0]), run(1, &verdicts[1]), run(2, &verdicts[0]), run(survey.len() - 1, &verdicts[1])];
        let map = Map::new(&runs);
        assert_eq!(map.cells[0].colour(), colour_of(Outcome::Frozen).expect("a colour"));
        assert_eq!(map.cells[1].colour(), SHADES[3]);
        assert_eq!(map.cells[2].colour(), SHADES[0]);
        assert!(Outcome::ALL[1..].iter().all(|&outcome| colour_of(outcome).is_some()));
    }
}
