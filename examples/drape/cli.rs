//! The command line.

use bevy_cloth::physics::Fabric;
use clap::Parser;
use example_common::cli::RunArgs;
use std::path::PathBuf;

/// Drapes a cloth: in a window, or off-screen to pictures and a mesh.
///
/// Without PATH a banner hangs from a rod (or, with --resolution, a square sheet from two corners). With PATH a mesh
/// of that file becomes cloth, and the rest of the file is shown with it.
#[derive(Parser, Debug, Clone)]
#[command(name = "drape")]
pub struct Cli {
    /// A glTF or GLB file with a mesh to turn into cloth.
    pub path: Option<PathBuf>,

    /// The node of PATH whose mesh becomes cloth [default: those with a `_CLOTH_PIN` attribute, or the only mesh].
    #[arg(long, value_name = "NAME", requires = "path")]
    pub node: Option<String>,

    /// Hold the vertices within this share of the cloth's height, from the top, where it has no `_CLOTH_PIN`.
    #[arg(long, value_name = "FRACTION", default_value = "0.15", value_parser = fraction, requires = "path")]
    pub pin_top: f32,

    /// The animation of PATH to play, by name or number; `none` for none [default: one that walks, else one that
    /// idles, else the first].
    #[arg(long, value_name = "NAME", requires = "path")]
    pub animation: Option<String>,

    /// Leave out a node of PATH, with all below it; may be given several times.
    #[arg(long, value_name = "NAME", requires = "path")]
    pub without: Vec<String>,

    /// Hang a square sheet of N × N vertices from two corners instead of the banner.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=400), conflicts_with = "path")]
    pub resolution: Option<u32>,

    #[command(flatten)]
    pub run: RunArgs,
}

impl Cli {
    /// What the cloth is made of.
    pub fn fabric(&self) -> Fabric {
        self.run.fabric.unwrap_or_else(Fabric::cotton)
    }
}

fn fraction(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err("a number above 0 and up to 1 is needed".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn refusal(arguments: &[&str]) -> clap::Error {
        Cli::try_parse_from([&["drape"], arguments].concat()).expect_err("refused")
    }

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn defaults() {
        let cli = Cli::try_parse_from(["drape"]).expect("no argument is needed");
        assert_eq!(cli.fabric(), Fabric::cotton());
        assert_eq!((cli.path, cli.resolution), (None, None));
    }

    #[test]
    fn every_option_is_read() {
        let line = "drape cape.glb --node Cape --pin-top 0.1 --animation 3 --without Sword --without Shield \
                    --fabric SILK";
        let cli = Cli::try_parse_from(line.split_whitespace()).expect("valid");
        assert_eq!(cli.fabric(), Fabric::silk());
        assert_eq!(cli.path, Some("cape.glb".into()));
        assert_eq!((cli.node.as_deref(), cli.pin_top, cli.animation.as_deref()), (Some("Cape"), 0.1, Some("3")));
        assert_eq!(cli.without, vec!["Sword".to_string(), "Shield".to_string()]);
    }

    #[test]
    fn bad_values_are_refused() {
        for arguments in [
            &["--resolution", "1"][..],
            &["--resolution", "100000"],
            &["--node", "Cape"],
            &["cape.glb", "--resolution", "9"],
            &["cape.glb", "--pin-top", "0"],
            &["cape.glb", "--pin-top", "NaN"],
        ] {
            assert_eq!(refusal(arguments).exit_code(), 2, "{arguments:?}");
        }
    }
}
