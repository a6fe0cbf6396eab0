//! `cullet run` and `cullet check`.

use crate::args;
use crate::exit::{Exit, Trouble, print};
use crate::progress::Progress;
use cullet_coordinator::link::{LinkError, Pool, PoolConfig, SpawnConfig};
use cullet_coordinator::preview;
use cullet_coordinator::run::{Outcome, RunError, RunOptions, next_folder, run as run_scene};
use cullet_coordinator::scene::{Scene, load};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Where runs go when no folder is named.
const RUNS: &str = "runs";

pub(crate) fn run(args: &args::Run) -> Result<Exit, Trouble> {
    say_logs(&args.voice);
    let scene = read_scene(&args.scene)?;
    let out = folder(args.out.as_deref(), &scene.name)?;
    let stop = stop_on_interrupt()?;
    let pool = start_pool(args).inspect_err(|_| forget_empty(&out))?;
    let mut progress = Progress::new(args.voice.quiet);
    let options = RunOptions { out: &out, stop: &stop };
    let outcome = run_scene(&scene, &pool, &options, &mut |news| progress.show(news));
    progress.done();
    pool.shutdown();
    let outcome = outcome.map_err(|error| trouble(&error))?;
    draw(&outcome.recording, &out)?;
    report(&outcome, &out, args.json, args.voice.quiet)?;
    Ok(exit_of(&outcome))
}

pub(crate) fn check(args: &args::Check) -> Result<Exit, Trouble> {
    let scene = read_scene(&args.scene)?;
    let mut lines = vec![
        format!("{}: {}", scene.name, scene.description),
        format!("{} bodies, {} steps of {} s", scene.bodies.len(), scene.steps(), scene.world.step),
    ];
    for body in &scene.bodies {
        let triangles = body.solid.mesh.triangles.len();
        let mass = body.volume * body.material.density;
        let material = &body.material.name;
        lines.push(format!("  {}: {material}, {mass:.4} kg, {triangles} triangles", body.name));
        lines.extend(body.repairs.iter().map(|line| format!("    {line}")));
    }
    lines.extend(scene.warnings.iter().map(|line| format!("warning: {line}")));
    print(lines.join("\n") + "\n")?;
    Ok(Exit::Done)
}

/// Reads a scene, or says everything that is wrong with it.
pub(crate) fn read_scene(args: &args::SceneArgs) -> Result<Scene, Trouble> {
    load(&args.scene, &args.set).map_err(|errors| Trouble::new(Exit::Usage, errors))
}

/// The folder that was asked for, made if it is not there, or a new one.
pub(crate) fn folder(asked: Option<&Path>, scene: &str) -> Result<PathBuf, Trouble> {
    let Some(folder) = asked else {
        let base = Path::new(RUNS);
        return next_folder(base, scene).map_err(|error| Trouble::file(base, error));
    };
    refuse_taken(folder)?;
    std::fs::create_dir_all(folder).map_err(|error| Trouble::file(folder, error))?;
    Ok(folder.to_owned())
}

/// A folder that holds a run is not written into.
pub(crate) fn refuse_taken(folder: &Path) -> Result<(), Trouble> {
    if folder.join("run.mcap").exists() || folder.join("run.mcap.partial").exists() {
        let text = format!("{}: there is a run in this folder; name another", folder.display());
        return Err(Trouble::new(Exit::Usage, text));
    }
    Ok(())
}

fn start_pool(args: &args::Run) -> Result<Pool, Trouble> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = args.workers.map_or((cores - 1).max(1), usize::from);
    let exe = std::env::current_exe().map_err(|error| Trouble::new(Exit::File, error))?;
    let spawn = SpawnConfig::new(exe, workers, usize::from(args.threads));
    let config = PoolConfig { spawn: Some(spawn), ..PoolConfig::default() };
    Pool::start(config).map_err(|error| no_link(&error))
}

pub(crate) fn no_link(error: &LinkError) -> Trouble {
    Trouble::new(Exit::Unreachable, error)
}

/// Removes a folder that was made for a run which never began.
fn forget_empty(folder: &Path) {
    std::fs::remove_dir(folder).ok();
}

/// A flag that the first interrupt sets; the second one ends the process.
pub(crate) fn stop_on_interrupt() -> Result<Arc<AtomicBool>, Trouble> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| Trouble::new(Exit::File, error))?;
    std::thread::spawn(move || {
        runtime.block_on(async {
            while tokio::signal::ctrl_c().await.is_ok() {
                if flag.swap(true, Ordering::Relaxed) {
                    std::process::exit(130);
                }
                eprintln!("interrupted: finishing the recording; once more to quit at once");
            }
        });
    });
    Ok(stop)
}

pub(crate) fn trouble(error: &RunError) -> Trouble {
    let exit = match error {
        RunError::Record(_) | RunError::File { .. } => Exit::File,
        RunError::World(_) | RunError::Lost(_) => Exit::Failed,
        RunError::Abandoned { .. } | RunError::OutOfOrder { .. } => Exit::Failed,
    };
    Trouble::new(exit, error)
}

/// Draws the pictures of a recording into a folder.
pub(crate) fn draw(recording: &Path, out: &Path) -> Result<(), Trouble> {
    preview::from_recording(recording, out).map_err(|error| Trouble::new(Exit::File, error))?;
    Ok(())
}

pub(crate) fn exit_of(outcome: &Outcome) -> Exit {
    match (outcome.interrupted, outcome.unmet.is_empty()) {
        (true, _) => Exit::Interrupted,
        (false, true) => Exit::Done,
        (false, false) => Exit::Unmet,
    }
}

fn report(outcome: &Outcome, out: &Path, json: bool, quiet: bool) -> Result<(), Trouble> {
    if json {
        print(outcome.summary.to_json())?;
    }
    for text in &outcome.unmet {
        eprintln!("expected, and does not hold: {text}");
    }
    if !quiet {
        let s = &outcome.summary;
        eprintln!(
            "{}: {} fractures, {} fragments, {} bodies left after {:.3} s in {:.1} s; {}",
            s.scene,
            s.fractures,
            s.fragments,
            s.bodies_final,
            s.sim_seconds,
            s.wall_seconds,
            out.display()
        );
    }
    Ok(())
}

/// Sends log lines to standard error: warnings, or more on request.
pub(crate) fn say_logs(voice: &args::Voice) {
    let level = match (voice.quiet, voice.verbose) {
        (true, _) => "error",
        (false, 0) => "warn,zenoh=error",
        (false, 1) => "info,zenoh=warn",
        (false, _) => "debug",
    };
    let filter = tracing_subscriber::EnvFilter::try_from_env("CULLET_LOG")
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new(level));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).init();
}
