//! Runs the scenes of contact as a user does.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The rows, and whether the status says that all are met.
fn contact(name: &str, scenes: &str) -> Vec<Value> {
    let json = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let mut command = Command::new(env!("CARGO_BIN_EXE_lab"));
    command.args(["contact", "--quick", "--only", scenes, "--json"]).arg(&json);
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
fn every_row_is_judged_by_what_it_measured() {
    let rows = contact("contact.json", "slope,drop,belt,absent");
    for scene in ["slope", "drop", "belt", "far colliders"] {
        assert!(rows.iter().any(|row| row["scene"].as_str().is_some_and(|name| name.starts_with(scene))), "{scene}");
    }
    for row in &rows {
        let Some(measured) = row["measured"].as_f64() else { panic!("{row}") };
        let wanted = &row["wanted"];
        let met = match (wanted["at_most"].as_f64(), wanted["at_least"].as_f64(), wanted["within"].as_array()) {
            (Some(limit), ..) => measured <= limit,
            (_, Some(limit), _) => measured >= limit,
            (.., Some(range)) => (range[0].as_f64()..=range[1].as_f64()).contains(&Some(measured)),
            _ => wanted == "known",
        };
        assert_eq!(row["met"], met, "{row}");
    }
}

#[test]
fn a_slope_is_judged_by_how_far_the_sheet_moves() {
    let rows = contact("slope.json", "slope");
    let moved = rows.iter().find(|row| row["what"] == "moved/mm").expect("a row");
    assert_eq!(moved["met"], moved["measured"].as_f64().is_some_and(|moved| moved <= 1.0), "{moved}");
}

#[test]
fn a_scene_that_is_none_is_refused() {
    let output =
        Command::new(env!("CARGO_BIN_EXE_lab")).args(["contact", "--only", "moon"]).output().expect("the lab runs");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("capstan"));
}
