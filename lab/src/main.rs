//! The command line of the laboratory.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use lab::{bench, budget, contact, game, stability, trade, validate};

/// Measures bevy_cloth.
#[derive(Parser)]
#[command(name = "lab", arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// What a frame costs: a sheet hung by two corners in many sizes, a hundred cloths, irregular meshes, the whole
    /// plugin.
    Bench(bench::Options),
    /// Is it right: cloths with an answer that is known without us. Status 1 if one is off by more than its tolerance.
    Validate(validate::Options),
    /// What accuracy costs: our solver's settings and XPBD against converged motion, as tables and pictures. Status 1 if a
    /// quality level is not as much cheaper than XPBD as is wanted.
    Trade(trade::Options),
    /// Does a frame budget keep its word under a load of several times it. Status 1 if not.
    Budget(budget::Options),
    /// Does it hold: thousands of cloths at the extremes of step, stiffness, mesh and motion. Status 1 if one gains energy, is
    /// not finite or panics, or too many stand still.
    Stability(stability::Options),
    /// Is contact right, and what does it cost: friction, depth, rest, impacts on solids of every kind. Status 1 if a figure is not
    /// what is wanted.
    Contact(contact::Options),
    /// Does it hold in a game's hands: moved in any schedule at any frame rate, jumped, turned, paused, drawn beside what it
    /// touches. Status 1 if a figure is not what is wanted.
    Game(game::Options),
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Bench(options) => bench::run(&options),
        Command::Validate(options) => validate::run(&options),
        Command::Trade(options) => trade::run(&options),
        Command::Budget(options) => budget::run(&options),
        Command::Stability(options) => stability::run(&options),
        Command::Contact(options) => contact::run(&options),
        Command::Game(options) => game::run(&options),
    };
    match outcome {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn bad_options_are_refused_with_status_2() {
        for line in [
            "lab fly",
            "lab bench --sparkle",
            "lab bench --sizes 1",
            "lab bench --sizes 20,many",
            "lab bench --sizes 20,,32",
            "lab bench --sizes 100000",
            "lab bench --threads 0",
            "lab bench --quality good",
            "lab bench --frames 0",
            "lab bench --repeat 0",
            "lab bench --parts sheets,flags",
            "lab validate --cases magic",
            "lab trade --scenes sky",
            "lab trade --sizes 1",
            "lab trade --methods pbd",
            "lab trade --repeat 0",
            "lab budget --load 0.5",
            "lab budget --frames 10",
            "lab stability --runs many",
            "lab stability --only -1",
            "lab contact --only moon",
            "lab contact --sizes 1",
            "lab game --only chess",
        ] {
            let refused = Cli::try_parse_from(line.split_whitespace()).err().unwrap_or_else(|| panic!("{line}"));
            assert_eq!(refused.exit_code(), 2, "{line}");
        }
    }
}
