//! Writes the bodies of a recording at one moment as OBJ files, one a body, for any modeller. Two
//! groups keep what shaders must tell apart: `outer`, the surface that the object had, and `crack`.
//!
//! ```sh
//! cargo run --release --example export_obj -- runs/pot-1/run.mcap 0.25 meshes
//! ```
//!
//! Vertices are where the body is in the world \[m\]; OBJ has no units, so a modeller that counts
//! in centimetres wants a scale of 100.

use cullet::{Recording, Solid};
use std::fmt::Write;
use std::path::Path;

fn obj(name: &str, solid: &Solid) -> Result<String, std::fmt::Error> {
    let mut text = format!("o {name}\n");
    for v in &solid.mesh.vertices {
        writeln!(text, "v {} {} {}", v.x, v.y, v.z)?;
    }
    for (group, crack) in [("outer", false), ("crack", true)] {
        writeln!(text, "g {group}")?;
        let faces = solid.mesh.triangles.iter().zip(&solid.surface);
        for ([a, b, c], _) in faces.filter(|(_, surface)| surface.is_crack() == crack) {
            writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1)?;
        }
    }
    Ok(text)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [path, time, folder] = &args[..] else {
        return Err("usage: export_obj RECORDING SECONDS FOLDER".into());
    };
    let recording = Recording::open(path.as_ref())?;
    std::fs::create_dir_all(folder)?;
    for row in recording.poses_at(time.parse()?) {
        let body = recording.body(row.id).ok_or("a pose of a body that was never born")?;
        let solid = recording.mesh(body)?.transformed(&row.pose);
        let file = Path::new(folder).join(format!("{:05}-{}.obj", body.id, body.name));
        std::fs::write(&file, obj(&body.name, &solid)?)?;
        println!("{}", file.display());
    }
    Ok(())
}
