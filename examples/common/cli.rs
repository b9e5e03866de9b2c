//! Options that every example has.

use crate::run::{RunOptions, run};
use bevy::prelude::*;
use bevy_cloth::physics::Fabric;
use clap::Args;
use std::path::{Path, PathBuf};

/// To be flattened into the command line of an example.
#[derive(Args, Debug, Clone)]
pub struct RunArgs {
    /// What the cloth is made of [default: what suits the scene].
    #[arg(long, value_name = "NAME", value_parser = fabric)]
    pub fabric: Option<Fabric>,

    /// Run without a window and write pictures, also where there is a display.
    #[arg(long)]
    pub headless: bool,

    /// Run without a window and write no pictures: only simulate and write the mesh.
    #[arg(long)]
    pub no_pictures: bool,

    /// Stop after N frames of 1/60 s [default: 300 without a window, never in a window].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub frames: Option<u32>,

    /// Folder for pictures and mesh [default: out/ and the name of the example].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Write the figures of the run as one JSON object.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

impl RunArgs {
    /// How to run the example of this name; `scene` is for the summary.
    pub fn options(self, name: &'static str, scene: String) -> RunOptions {
        RunOptions {
            name,
            scene,
            headless: self.headless || self.no_pictures,
            pictures: !self.no_pictures,
            frames: self.frames,
            out: self.out.unwrap_or_else(|| Path::new("out").join(name)),
            json: self.json,
        }
    }

    /// Runs an example that has one scene.
    pub fn show(self, name: &'static str, scene: impl Plugin) -> AppExit {
        exit(run(self.options(name, name.into()), |app| {
            app.add_plugins(scene);
        }))
    }
}

/// Tells the user what went wrong, if anything.
pub fn exit(result: Result<(), String>) -> AppExit {
    match result {
        Ok(()) => AppExit::Success,
        Err(problem) => {
            eprintln!("error: {problem}");
            AppExit::error()
        }
    }
}

fn fabric(name: &str) -> Result<Fabric, String> {
    Fabric::by_name(name).ok_or_else(|| {
        let names: Vec<_> = Fabric::presets().map(|(name, _)| name).collect();
        format!("there is no such fabric; choose one of {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Parser, error::ErrorKind};

    #[derive(Parser, Debug)]
    struct Cli {
        #[command(flatten)]
        run: RunArgs,
    }

    fn parse(line: &str) -> Result<RunArgs, clap::Error> {
        Cli::try_parse_from(["example"].into_iter().chain(line.split_whitespace())).map(|cli| cli.run)
    }

    #[test]
    fn without_options_it_runs_in_a_window_for_ever() {
        let args = parse("").expect("no option is needed");
        assert_eq!(args.fabric, None);
        let options = args.options("curtain", "a scene".into());
        assert_eq!((options.name, options.scene.as_str(), options.frames), ("curtain", "a scene", None));
        assert_eq!((options.headless, options.pictures), (false, true));
        assert_eq!((options.out, options.json), (Path::new("out").join("curtain"), None));
    }

    #[test]
    fn every_option_is_read() {
        let args = parse("--fabric SILK --headless --frames 9 --out here --json figures.json").expect("valid");
        assert_eq!(args.fabric, Some(Fabric::silk()));
        let options = args.options("curtain", String::new());
        assert_eq!((options.headless, options.pictures, options.frames), (true, true, Some(9)));
        assert_eq!((options.out, options.json), ("here".into(), Some("figures.json".into())));
    }

    #[test]
    fn without_pictures_there_is_no_window_either() {
        let options = parse("--no-pictures").expect("valid").options("curtain", String::new());
        assert_eq!((options.headless, options.pictures), (true, false));
    }

    #[test]
    fn an_unknown_fabric_is_refused_with_the_names_that_exist() {
        let error = parse("--fabric chainmail").expect_err("refused");
        assert_eq!((error.kind(), error.exit_code()), (ErrorKind::ValueValidation, 2));
        assert!(error.to_string().contains("cotton, silk"), "{error}");
    }

    #[test]
    fn bad_values_are_refused() {
        for line in ["--frames 0", "--frames many", "--sparkle", "stray"] {
            assert_eq!(parse(line).expect_err("refused").exit_code(), 2, "{line}");
        }
    }
}
