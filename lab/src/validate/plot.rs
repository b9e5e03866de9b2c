//! All rows in one picture.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::Row;
use crate::plot::Figure;

/// Error of each row over its tolerance, a line for each kind of answer.
pub struct Errors<'a>(pub &'a [Row]);

/// Errors below this are drawn there.
const LEAST: f64 = 1e-4;
const MOST: f64 = 10.0;
const LINE: u32 = 34;
const FONT: (&str, u32) = ("sans-serif", 18);
const RIGHT: RGBColor = RGBColor(0, 110, 180);
const OFF: RGBColor = RGBColor(210, 40, 30);

impl Errors<'_> {
    /// In the order they stand.
    fn cases(&self) -> Vec<&'static str> {
        let mut cases: Vec<_> = self.0.iter().map(|row| row.case).collect();
        cases.dedup();
        cases
    }
}

impl Figure for Errors<'_> {
    fn size(&self) -> (u32, u32) {
        (1000, 130 + LINE * self.cases().len() as u32)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let cases = self.cases();
        let title = "Error of each row over what it may be: what is left of 1 is right";
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 22))
            .margin(15)
            .x_label_area_size(50)
            .y_label_area_size(240)
            .build_cartesian_2d((LEAST..MOST).log_scale(), 0.0..cases.len() as f64)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .disable_y_axis()
            .x_desc("|error| / tolerance (those below 1e-4 stand there)")
            .x_label_formatter(&|x| format!("{x}"))
            .label_style(FONT)
            .draw()?;
        // From the top down.
        let height = |case: usize| (cases.len() - case) as f64 - 0.5;
        let inside = chart.plotting_area();
        inside.draw(&PathElement::new([(1.0, 0.0), (1.0, cases.len() as f64)], BLACK.stroke_width(2)))?;
        for (which, case) in cases.iter().enumerate() {
            // To the left of the axis.
            inside.draw(&(EmptyElement::at((LEAST, height(which))) + Text::new(*case, (-235, -5), FONT)))?;
            for row in self.0.iter().filter(|row| row.case == *case) {
                let error = (row.error.abs() / row.tolerance).clamp(LEAST, MOST);
                let colour = if row.pass { RIGHT } else { OFF };
                inside.draw(&Circle::new((error, height(which)), 5, colour.mix(0.5).filled()))?;
            }
        }
        Ok(())
    }
}
