//! Runs the bench as a user does.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn bench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lab")).arg("bench").args(arguments).output().expect("the lab runs")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn a_table_and_json_come_out() {
    let path = file("bench.json");
    let json = path.to_str().expect("UTF-8");
    let output = bench(&["--parts", "sheets", "--sizes", "10,12", "--frames", "16", "--json", json]);
    assert!(output.status.success(), "{}", stderr(&output));
    let table = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(table.contains("10²") && table.contains("12²") && table.contains("bytes per vertex"), "{table}");

    let text = std::fs::read_to_string(path).expect("a file");
    let records: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let kinds: Vec<_> = records.iter().map(|record| record["kind"].as_str().expect("a kind")).collect();
    assert_eq!(kinds, ["solver", "solver", "target"]);
    assert_eq!((&records[1]["side"], &records[1]["frames"]), (&12.into(), &16.into()));
    for key in ["assembly_ms", "solve_ms", "iterations", "spmv_us", "frame_spmvs", "bytes_per_vertex", "fall_m"] {
        assert!(records[0][key].as_f64().is_some_and(|value| value > 0.0), "{key} in {}", records[0]);
    }
}

#[test]
fn bad_options_exit_with_2_and_say_why() {
    let folder = env!("CARGO_TARGET_TMPDIR");
    for (arguments, word) in [
        (&["--sizes", "1"][..], "--sizes"),
        (&["--threads", "none"], "--threads"),
        (&["--parts", "flags"], "crowd"),
        (&["--json", folder], folder),
    ] {
        let output = bench(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(word), "{}", stderr(&output));
    }
}
