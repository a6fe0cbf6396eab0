//! Prints the cumulative mass distribution of the fragments of a recording as CSV, which is what
//! fragmentation laws are plotted from: for each mass, how many fragments are at least as heavy.
//!
//! ```sh
//! cargo run --release --example fragment_sizes -- runs/pot-1/run.mcap > sizes.csv
//! ```
//!
//! `size_m` is the diameter of a ball of the fragment's volume. `sampled` fragments were drawn from
//! a law and not solved: leave them out when you compare a solver with a measurement.

use cullet::Recording;
use cullet::messages::EventKind;
use std::collections::BTreeSet;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: fragment_sizes RECORDING")?;
    let recording = Recording::open(path.as_ref())?;
    if !recording.complete {
        eprintln!("{path}: the run was cut off; what was saved follows");
    }
    let fractures = recording.events.iter().filter(|e| e.kind() == EventKind::Fractured);
    let broken: BTreeSet<u64> = fractures.filter_map(|event| event.body).collect();
    let sampled: BTreeSet<u64> =
        recording.sampled.iter().flat_map(|fracture| &fracture.fragments).copied().collect();

    // Fragments that broke no further, the heaviest first.
    let mut last: Vec<_> = recording
        .bodies
        .iter()
        .filter(|body| body.parent.is_some() && !broken.contains(&body.id))
        .collect();
    last.sort_by(|a, b| b.mass.total_cmp(&a.mass));

    println!("object,fragment,mass_kg,size_m,as_heavy,sampled");
    for (before, body) in last.iter().enumerate() {
        let size = (6.0 * body.volume / std::f64::consts::PI).cbrt();
        let sampled = sampled.contains(&body.id);
        println!("{},{},{},{size},{},{sampled}", body.object, body.name, body.mass, before + 1);
    }
    Ok(())
}
