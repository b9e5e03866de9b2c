//! Runs the survey of the extremes as a user does.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

#[test]
fn a_table_and_json_come_out_and_a_run_can_be_seen_alone() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stability");
    let json = out.with_extension("json");
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lab"));
        command.args(["stability", "--runs", "6", "--cell-runs", "0", "--plugin-runs", "2", "--seed", "3"]);
        let output = command.args(arguments).output().expect("the lab runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let text = run(&["--json", json.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")]);
    assert!(text.contains("core: 6 runs, 0 failed") && text.contains("plugin: 2 runs, 0 failed"), "{text}");

    let rows = std::fs::read_to_string(json).expect("a file");
    let rows: Vec<Value> = rows.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(rows.len(), 6 + 2);
    assert!(rows.iter().all(|row| row["sample"]["dt"].is_f64() && row["steps"] == 48), "{rows:?}");

    // Alone, a run is what it was among the others.
    let gain = format!("gain: {}", rows[4]["gain"]);
    let alone = run(&["--only", "4"]);
    assert!(alone.contains("iterations") && alone.contains(&gain), "{gain}: {alone}");
}
