//! Runs `drape` as a user does. The unit tests of its command line run here too: Cargo would not build the example
//! itself if it were a test.

use serde_json::Value;
use std::{
    env,
    fs::{create_dir_all, read, read_to_string, remove_dir_all},
    path::{Path, PathBuf},
    process::{Command, Output},
};

#[path = "../drape/cli.rs"]
mod cli;

/// Cargo builds the examples before the tests, into the folder beside that of the tests.
fn drape(arguments: &[&str]) -> Output {
    let test = env::current_exe().expect("the test's own path");
    let profile = test.ancestors().nth(2).expect("target/PROFILE");
    let program = profile.join("examples").join("drape").with_extension(env::consts::EXE_EXTENSION);
    Command::new(&program).args(arguments).output().unwrap_or_else(|error| panic!("{}: {error}", program.display()))
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // It is there only after an earlier run.
    let _ = remove_dir_all(&folder);
    create_dir_all(&folder).expect("a folder");
    folder
}

fn number(json: &Value, key: &str) -> f64 {
    json[key].as_f64().unwrap_or_else(|| panic!("{key} in {json}"))
}

/// Simulates without drawing and returns the figures and the mesh.
fn simulate(name: &str, arguments: &[&str]) -> (Value, gltf::Gltf) {
    let folder = folder(name);
    let (out, json) = (folder.join("out"), folder.join("figures.json"));
    let files = ["--no-pictures", "--out", out.to_str().expect("UTF-8"), "--json", json.to_str().expect("UTF-8")];
    let output = drape(&[&files, arguments].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let figures = serde_json::from_str(&read_to_string(json).expect("figures")).expect("JSON");
    let mesh = read(out.join("drape.glb")).expect("a mesh");
    (figures, gltf::Gltf::from_slice(&mesh).expect("valid glTF"))
}

#[test]
fn help_succeeds_and_names_every_option() {
    let output = drape(&["--help"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8_lossy(&output.stdout);
    for option in ["--headless", "--frames", "--fabric", "--resolution", "--out", "--json", "--node", "--pin-top"] {
        assert!(text.contains(option), "{option}");
    }
}

#[test]
fn bad_options_exit_with_2_and_say_why() {
    for (arguments, word) in [
        (&["--sparkle"][..], "--sparkle"),
        (&["--frames", "0"], "--frames"),
        (&["--resolution", "1"], "--resolution"),
        (&["--fabric", "chainmail"], "cotton"),
    ] {
        let output = drape(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(word), "{}", stderr(&output));
    }
}

#[test]
fn a_missing_file_fails() {
    let output = drape(&["no-such-file.glb", "--no-pictures"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("no-such-file.glb"), "{}", stderr(&output));
}

#[test]
fn an_unknown_node_fails_with_the_names_that_exist() {
    let banner = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/banner.glb");
    let out = folder("unknown_node");
    let output = drape(&[banner, "--node", "Sail", "--no-pictures", "--out", out.to_str().expect("UTF-8")]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("\"Sail\"") && stderr(&output).contains("Banner"), "{}", stderr(&output));
}

#[test]
fn a_folder_that_cannot_be_made_fails() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let output = drape(&["--no-pictures", "--frames", "1", "--out", file]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("Cargo.toml"), "{}", stderr(&output));
}

#[test]
fn the_banner_hangs_from_its_rings() {
    let (figures, mesh) = simulate("banner", &["--frames", "20"]);
    assert_eq!((number(&figures, "steps"), number(&figures, "cloths")), (20.0, 1.0));
    assert_eq!(number(&figures, "pinned"), 7.0);
    assert_eq!(number(&figures, "vertices"), 2793.0);
    assert!(number(&figures, "ms_per_step") > 0.0 && number(&figures, "iterations_per_step") > 0.0);
    assert!(number(&figures, "max_stretch") < 0.2 && number(&figures, "rms_stretch") < 0.01, "{figures}");
    assert!(number(&figures, "kinetic_energy") > 0.0);
    let top = figures["bounds"][1][1].as_f64().expect("a height");
    assert!((top - 2.15).abs() < 0.05, "the rings are at 2.15 m, the cloth reaches {top} m");

    let primitive = mesh.meshes().next().and_then(|mesh| mesh.primitives().next()).expect("a primitive");
    assert_eq!(primitive.get(&gltf::Semantic::Positions).map(|accessor| accessor.count()), Some(2793));
}

#[test]
fn a_sheet_of_silk_falls() {
    let (short, _) = simulate("sheet_short", &["--resolution", "12", "--fabric", "silk", "--frames", "1"]);
    let (long, _) = simulate("sheet_long", &["--resolution", "12", "--fabric", "silk", "--frames", "30"]);
    assert_eq!((&long["fabric"], number(&long, "vertices")), (&Value::from("silk"), 144.0));
    assert_eq!(number(&long, "pinned"), 2.0);
    let lowest = |figures: &Value| figures["bounds"][0][1].as_f64().expect("a height");
    // Half a second of free fall would be 1.2 m; the far edge, swinging on a hinge, falls faster.
    let fall = lowest(&short) - lowest(&long);
    assert!((0.8..1.7).contains(&fall), "{fall} m");
}

#[test]
fn a_run_repeats_exactly() {
    let run = |name| simulate(name, &["--resolution", "8", "--frames", "10"]).0["bounds"].clone();
    assert_eq!(run("first_time"), run("second_time"));
}
