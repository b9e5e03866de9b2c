//! Writes `assets/banner.glb`, the cloth of the default `drape` scene: `cargo run --example make_banner`.

use example_common::{banner::banner, glb::to_glb};

fn main() -> Result<(), String> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/banner.glb");
    let bytes = to_glb(&[banner()?])?;
    std::fs::write(path, &bytes).map_err(|error| format!("cannot write {path}: {error}"))?;
    println!("wrote {path} ({} kB)", bytes.len() / 1000);
    Ok(())
}
