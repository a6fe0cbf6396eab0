//! Runs one scene on this machine and prints its summary.
//!
//! ```sh
//! cargo run --release --example run_scene -- scenes/pot runs/pot world.seed=7
//! ```

use cullet::{LocalWorkers, News, RunOptions, Scene, run};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let (Some(scene), Some(out)) = (args.next(), args.next()) else {
        return Err("usage: run_scene SCENE OUT [PATH=VALUE ...]".into());
    };
    let overrides: Vec<String> = args.collect();
    let scene = Scene::load(&scene, &overrides)?;
    eprintln!("{}: {} bodies, {} steps", scene.name, scene.bodies.len(), scene.steps());

    let out = PathBuf::from(out);
    let stop = AtomicBool::new(false);
    let options = RunOptions::new(&out, &stop);
    let mut fractures = 0;
    let outcome = run(&scene, &LocalWorkers::default(), &options, &mut |news| match news {
        News::At(position) if position.fractures > fractures => {
            fractures = position.fractures;
            eprintln!("{:.3} s: {fractures} fractures so far", position.time);
        }
        News::At(_) => {}
        News::Line(line) | News::Results(line) => eprintln!("{line}"),
    })?;

    // What the scene expects of itself, and does not hold.
    for sentence in &outcome.unmet {
        eprintln!("not as expected: {sentence}");
    }
    print!("{}", outcome.summary.to_json());
    Ok(())
}
