//! Runs a scene at several impact speeds, as artists wedge a value, and prints a CSV: how many
//! fragments, the largest one, and the energy that the cracks took.
//!
//! ```sh
//! cargo run --release --example wedge -- scenes/pot pot runs/wedge 2 4 8 16
//! ```
//!
//! The named body is thrown straight down (−z) at each speed \[m/s\], from where the scene has it.

use cullet::{LocalPool, LocalWorkers, Recording, RunOptions, Scene};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scene, body, out, speeds @ ..] = &args[..] else {
        return Err("usage: wedge SCENE BODY OUT SPEED ...".into());
    };
    let stop = AtomicBool::new(false);
    // One pool for all runs: the workers start once.
    let pool = LocalPool::start(&LocalWorkers::default())?;
    println!("speed_m_s,fragments,largest_kg,crack_energy_J,digest");
    for speed in speeds {
        let velocity = format!("body.{body}.velocity=[0, 0, -{speed}]");
        let scene = Scene::load(scene, &[velocity])?;
        let out = PathBuf::from(out).join(speed);
        let outcome = pool.run(&scene, &RunOptions::new(&out, &stop), &mut |_| {})?;

        let recording = Recording::open(&outcome.recording)?;
        let fragments = recording.bodies.iter().filter(|body| body.parent.is_some());
        let largest = fragments.map(|fragment| fragment.mass).fold(0.0, f64::max);
        let (summary, energy) = (&outcome.summary, outcome.summary.ledger.fracture_energy);
        println!("{speed},{},{largest},{energy},{}", summary.fragments, summary.digest);
    }
    Ok(())
}
