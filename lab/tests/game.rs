//! Runs the scenes of a game as a user does.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The rows, and whether the status says that all are met.
fn game(name: &str, scenes: &str) -> Vec<Value> {
    let json = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let mut command = Command::new(env!("CARGO_BIN_EXE_lab"));
    command.args(["game", "--quick", "--only", scenes, "--json"]).arg(&json);
    let output = command.output().expect("the lab runs");
    let lines = std::fs::read_to_string(json).expect("a file");
    let rows: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let all = rows.iter().all(|row| row["met"] == true);
    assert_eq!(output.status.code(), Some(if all { 0 } else { 1 }), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(text.contains(&format!("{} rows, ", rows.len())), "{text}");
    rows
}

#[test]
fn what_is_moved_in_update_is_judged_beside_what_is_moved_in_fixed_update() {
    let rows = game("game-runner.json", "runner");
    let shakes: Vec<_> = rows.iter().filter(|row| row["what"] == "shake, rms/mm").collect();
    assert_eq!(shakes.len(), 6);
    for three in shakes.chunks(3) {
        assert!(three[0]["scene"].as_str().is_some_and(|scene| scene.ends_with("FixedUpdate")), "{three:?}");
        let reference = three[0]["measured"].as_f64().expect("a figure");
        assert_eq!(three[0]["wanted"], "known");
        for row in &three[1..] {
            let limit = row["wanted"]["at_most"].as_f64().expect("a limit");
            assert!((limit - 1.5 * reference - 0.1).abs() < 1e-12, "{row}");
        }
    }
}

#[test]
fn every_other_scene_gives_figures() {
    let rows = game("game.json", "lift,curtain,jump,event,vehicle");
    for scene in ["sheet on a lift", "curtain", "cape, turned", "cape, moved", "sheet on a box", "flag"] {
        assert!(rows.iter().any(|row| row["scene"].as_str().is_some_and(|name| name.starts_with(scene))), "{scene}");
    }
    for row in &rows {
        assert!(row["measured"].as_f64().is_some(), "{row}");
    }
}

#[test]
fn a_scene_that_is_none_is_refused() {
    let output =
        Command::new(env!("CARGO_BIN_EXE_lab")).args(["game", "--only", "chess"]).output().expect("the lab runs");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("curtain"));
}
