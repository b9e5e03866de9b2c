//! Runs the trade as a user does.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

#[test]
fn tables_json_and_pictures_come_out() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("trade");
    let (json, cache) = (folder.with_extension("json"), folder.join("cache"));
    let output = Command::new(env!("CARGO_BIN_EXE_lab"))
        .args(["trade", "--scenes", "flag", "--sizes", "6", "--methods", "level,xpbd", "--repeat", "1", "--out"])
        .arg(&folder)
        .arg("--cache")
        .arg(&cache)
        .arg("--json")
        .arg(&json)
        .output()
        .expect("the lab runs");
    // So small a cloth is not judged.
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(text.contains("Pareto front of ours") && text.contains("flag 6²"), "{text}");

    let lines = std::fs::read_to_string(json).expect("a file");
    let records: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let of = |kind: &str| records.iter().filter(|record| record["kind"] == kind).collect::<Vec<_>>();
    let (methods, verdicts) = (of("method"), of("verdict"));
    assert!(methods.len() > 8 && verdicts.len() == 4, "{lines}");
    for key in ["ms", "motion_m", "settled_m", "stretch", "energy"] {
        assert!(methods[0][key].as_f64().is_some_and(|value| value != 0.0), "{key} in {}", methods[0]);
    }
    for measure in ["motion", "settled", "stretch", "energy"] {
        for extension in ["svg", "png"] {
            let path = folder.join(format!("flag-6-{measure}.{extension}"));
            assert!(std::fs::metadata(&path).is_ok_and(|file| file.len() > 1000), "{}", path.display());
        }
    }
    assert_eq!(std::fs::read_dir(cache).expect("a folder").count(), 2);
}
