//! Pictures of what was measured, each as SVG and as PNG.

use std::path::Path;
use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

/// Something that can be drawn on anything.
pub trait Figure {
    /// Width and height, pixels.
    fn size(&self) -> (u32, u32);
    /// Draws it on a white area of that size.
    ///
    /// # Errors
    /// Those of the backend.
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), DrawingAreaErrorKind<B::ErrorType>>;
}

/// Writes `name.svg` and `name.png` into the folder `out`, which is made if it is not there.
///
/// # Errors
/// If a file cannot be written.
pub fn save(figure: &impl Figure, out: &Path, name: &str) -> Result<(), String> {
    static FONT: Once = Once::new();
    FONT.call_once(|| {
        // It fails only for bytes that are no font.
        let _ = register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    });
    std::fs::create_dir_all(out).map_err(|error| format!("cannot make {}: {error}", out.display()))?;
    let file = |extension: &str| out.join(name).with_extension(extension);
    let (svg, png) = (file("svg"), file("png"));
    draw(figure, SVGBackend::new(&svg, figure.size()).into_drawing_area(), &svg)?;
    draw(figure, BitMapBackend::new(&png, figure.size()).into_drawing_area(), &png)
}

fn draw<B: DrawingBackend>(figure: &impl Figure, area: DrawingArea<B, Shift>, path: &Path) -> Result<(), String> {
    let drawn = area.fill(&WHITE).and_then(|()| figure.draw(&area)).and_then(|()| area.present());
    drawn.map_err(|error| format!("cannot draw {}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Dot;

    impl Figure for Dot {
        fn size(&self) -> (u32, u32) {
            (60, 40)
        }

        fn draw<B: DrawingBackend>(
            &self,
            area: &DrawingArea<B, Shift>,
        ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
            area.draw(&Circle::new((30, 20), 5, BLACK.filled()))?;
            area.draw(&Text::new("a", (2, 2), ("sans-serif", 12)))
        }
    }

    #[test]
    fn a_figure_is_saved_in_both_formats() {
        let out = std::env::temp_dir().join(format!("lab-plot-{}", std::process::id()));
        save(&Dot, &out, "dot").unwrap();
        let svg = std::fs::read_to_string(out.join("dot.svg")).unwrap();
        assert!(svg.contains("circle") && svg.contains('a'));
        assert!(std::fs::metadata(out.join("dot.png")).unwrap().len() > 100);
        std::fs::remove_dir_all(out).unwrap();
    }
}
