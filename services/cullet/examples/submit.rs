//! Sends a scene to a running farm, follows it to its end, and fetches what it recorded.
//!
//! ```sh
//! cullet coordinator --listen tcp/127.0.0.1:7447 --workers 2 &
//! cargo run --release --example submit -- tcp/127.0.0.1:7447 scenes/pot fetched
//! ```

use cullet::{Client, Recording, Scene, Terms};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [endpoint, scene, out, overrides @ ..] = &args[..] else {
        return Err("usage: submit ENDPOINT SCENE OUT [PATH=VALUE ...]".into());
    };
    // The scene is checked here: a wrong one is not sent.
    let scene = Scene::load(scene, overrides)?;
    let client = Client::connect(endpoint)?;
    // Higher priorities go first; 0 is usual.
    let terms = Terms { priority: 10, ..Terms::unique() };
    let run = client.submit(&scene.bundle(), &terms)?;
    eprintln!("run {run} of {}", client.runs()?.len());

    let info = client.follow(run, 0, |news| {
        for line in &news.lines {
            eprintln!("{line}");
        }
        if let Some(position) = news.run.position {
            eprintln!("{:.3} of {:.3} s", position.time, position.end);
        }
    })?;
    let files = client.fetch(&info, Path::new(out))?;
    client.enough(run);
    eprintln!("{}: {} files in {out}", info.state.word(), files.len());

    let recording = Recording::open(&Path::new(out).join("run.mcap"))?;
    print!("{}", recording.summary().to_json());
    Ok(())
}
