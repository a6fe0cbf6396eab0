//! `cullet coordinator`, `cullet worker`, `cullet submit`: the same run across terminals and
//! machines.

use crate::args;
use crate::exit::{Exit, Trouble, print};
use crate::folder::{Folder, refuse_taken};
use crate::run::{draw, exit_of, no_link, read_scene, say_logs, trouble};
use crate::signals::stop_when_told;
use cullet_coordinator::link::client::{Client, Handle, Outcome};
use cullet_coordinator::link::{
    Content, LinkError, Pool, PoolConfig, Share, SpawnConfig, Submission, Submissions, check_path,
};
use cullet_coordinator::run::{News, RunOptions, next_folder, run as run_scene};
use cullet_coordinator::scene::{Bundle, Scene, SceneFile, load_bundle};
use cullet_worker::{WorkerConfig, WorkerError};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Between looks at the desk.
const PERIOD: Duration = Duration::from_millis(100);
/// Between two lines of a run's position for the client that follows.
const NEWS_PERIOD: Duration = Duration::from_secs(2);
/// A client that has not asked for this long is gone: nobody waits for it before leaving.
const LINGER: Duration = Duration::from_secs(10);
/// How long to look for a coordinator.
const SEARCH: Duration = Duration::from_secs(10);
/// The file of a bundle that names the scene, its main file and the keys of its files, a line each.
const MANIFEST: &str = "bundle.txt";
/// What a run leaves for the client.
const PRODUCTS: [&str; 4] = ["run.mcap", "summary.json", "preview.png", "preview.gif"];

pub(crate) fn coordinator(args: &args::Coordinator) -> Result<Exit, Trouble> {
    say_logs(&args.voice);
    let stop = stop_when_told("clients are told first")?;
    let exe = std::env::current_exe().map_err(|error| Trouble::new(Exit::File, error))?;
    let spawn = (args.workers > 0)
        .then(|| SpawnConfig::new(exe, usize::from(args.workers), usize::from(args.threads)));
    let listen = Some(args.listen.clone());
    let pool = Pool::start(PoolConfig { listen, spawn, ..PoolConfig::default() })
        .map_err(|error| no_link(&error))?;
    if !args.voice.quiet {
        eprintln!("listening on {}", pool.endpoint());
    }
    let desk = pool.submissions();
    let mut done = 0;
    while !stop.load(Ordering::Relaxed) && args.runs.is_none_or(|most| done < most) {
        let Some(submission) = desk.next() else {
            std::thread::sleep(PERIOD);
            continue;
        };
        serve(&pool, submission, args, &stop);
        done += 1;
    }
    take_leave(&desk);
    pool.shutdown();
    Ok(Exit::Done)
}

/// Tells the clients that still wait that their scenes will not be run, and stays until every
/// client has heard the end of its own and fetched what there is.
fn take_leave(desk: &Submissions) {
    loop {
        while let Some(submission) = desk.next() {
            desk.progress(submission.id, "error: the coordinator left before the run began");
            desk.finish(submission.id, Vec::new(), Exit::Unreachable.code());
        }
        if !desk.awaited(LINGER) {
            return;
        }
        std::thread::sleep(PERIOD);
    }
}

/// Runs one submission and leaves its files for the client.
fn serve(pool: &Pool, submission: Submission, args: &args::Coordinator, stop: &AtomicBool) {
    let desk = pool.submissions();
    let id = submission.id;
    let (files, exit) = match serve_scene(pool, submission, args, stop) {
        Ok((out, exit)) => (products(&out), exit),
        Err(trouble) => {
            desk.progress(id, &format!("error: {trouble}"));
            if !args.voice.quiet {
                eprintln!("submission {id}: {trouble}");
            }
            (Vec::new(), trouble.exit)
        }
    };
    desk.finish(id, files, exit.code());
}

fn serve_scene(
    pool: &Pool,
    submission: Submission,
    args: &args::Coordinator,
    stop: &AtomicBool,
) -> Result<(PathBuf, Exit), Trouble> {
    let id = submission.id;
    let scene = unpack(submission)?;
    let out =
        next_folder(&args.out, &scene.name).map_err(|error| Trouble::file(&args.out, error))?;
    if !args.voice.quiet {
        eprintln!("submission {id}: {} into {}", scene.name, out.display());
    }
    let desk = pool.submissions();
    let mut told = Instant::now();
    let options = RunOptions { out: &out, stop };
    let outcome =
        run_scene(&scene, &pool.run(Share::default()), &options, &mut |news| match news {
            News::Line(line) => desk.progress(id, line),
            News::At(p) if told.elapsed() >= NEWS_PERIOD => {
                told = Instant::now();
                let text = format!("{:.3} of {:.3} s, {} bodies", p.time, p.end, p.bodies);
                desk.progress(id, &text);
            }
            News::At(_) => {}
        });
    let outcome = outcome.map_err(|error| trouble(&error))?;
    let drawn = draw(&outcome.recording, &out);
    if let Err(trouble) = &drawn {
        desk.progress(id, &format!("warning: {trouble}"));
    }
    if outcome.interrupted {
        desk.progress(id, "the coordinator was told to stop: the recording ends here");
    }
    for text in &outcome.unmet {
        desk.progress(id, &format!("expected, and does not hold: {text}"));
    }
    Ok((out, exit_of(&outcome, drawn.is_ok())))
}

fn products(out: &Path) -> Vec<(String, Content)> {
    let there = PRODUCTS.iter().filter(|name| out.join(name).is_file());
    there.map(|name| ((*name).to_owned(), Content::Path(out.join(name)))).collect()
}

/// A scene as files for the wire: the manifest first, then each file under its number. Keys may
/// lead out of the scene's folder, which a path on the wire may not; so the manifest holds them.
fn pack(scene: &Scene) -> Vec<(String, Vec<u8>)> {
    let bundle = scene.bundle();
    let mut manifest = format!("{}\n{}\n", bundle.name, bundle.main);
    let mut files = Vec::new();
    for (number, file) in bundle.files.iter().enumerate() {
        manifest.extend([file.key.as_str(), "\n"]);
        files.push((format!("files/{number}"), file.bytes.to_vec()));
    }
    files.insert(0, (MANIFEST.to_owned(), manifest.into_bytes()));
    files
}

fn unpack(submission: Submission) -> Result<Scene, Trouble> {
    let bundle = bundle(submission.bundle, submission.overrides)?;
    load_bundle(&bundle).map_err(|errors| Trouble::new(Exit::Usage, errors))
}

fn bundle(files: Vec<(String, Vec<u8>)>, overrides: Vec<String>) -> Result<Bundle, Trouble> {
    let broken = || Trouble::new(Exit::Usage, "the bundle does not begin with its manifest");
    let mut files = files.into_iter();
    let (path, manifest) = files.next().ok_or_else(broken)?;
    let manifest = String::from_utf8(manifest).map_err(|_| broken())?;
    let mut lines = manifest.lines();
    let (Some(name), Some(main), true) = (lines.next(), lines.next(), path == MANIFEST) else {
        return Err(broken());
    };
    // The name becomes part of a folder's name here: it must not lead anywhere else.
    if name.contains('/') || check_path(name).is_err() {
        return Err(Trouble::new(Exit::Usage, format!("{name:?} is no name for a scene")));
    }
    let keys: Vec<&str> = lines.collect();
    if keys.len() != files.len() {
        return Err(Trouble::new(Exit::Usage, "the manifest does not name every file"));
    }
    let files = keys.into_iter().zip(files);
    let files =
        files.map(|(key, (_, bytes))| SceneFile { key: key.to_owned(), bytes: bytes.into() });
    Ok(Bundle { name: name.to_owned(), main: main.to_owned(), overrides, files: files.collect() })
}

pub(crate) fn worker(args: &args::Worker) -> Result<Exit, Trouble> {
    say_logs(&args.voice);
    let name = args.name.clone().unwrap_or_else(|| format!("worker-{}", std::process::id()));
    if !args.voice.quiet && !args.parent_watch {
        eprintln!("{name} asks {} for jobs, as soon as it is there", args.connect.join(", "));
    }
    let config = WorkerConfig {
        connect: args.connect.clone(),
        name,
        threads: usize::from(args.threads),
        parent_watch: args.parent_watch,
        job: Some(crate::job::command(args.threads, args.memory)?),
        stop: stop_when_told("the job at hand is given back")?,
        ..WorkerConfig::default()
    };
    let exit = |error: &WorkerError| match error {
        WorkerError::Connect { .. } => Exit::Unreachable,
        WorkerError::Threads { .. } => Exit::Failed,
        WorkerError::NoEndpoint | WorkerError::Wire(_) => Exit::Usage,
    };
    cullet_worker::run(config).map_err(|error| Trouble::new(exit(&error), error))?;
    Ok(Exit::Done)
}

pub(crate) fn submit(args: &args::Submit) -> Result<Exit, Trouble> {
    say_logs(&args.voice);
    let scene = read_scene(&args.scene)?;
    // Said before the run and not after it.
    args.out.as_deref().map_or(Ok(()), refuse_taken)?;
    let client = Client::connect(&args.connect)
        .and_then(|client| client.with(cullet_proto::keys::DEFAULT_COORDINATOR, SEARCH))
        .map_err(|error| no_link(&error))?;
    let handle = client
        .submit(&pack(&scene), &scene.overrides, ticket())
        .map_err(|error| refused(&error))?;
    let quiet = args.voice.quiet;
    let outcome = client
        .follow(handle, |line| {
            if !quiet {
                eprintln!("{line}");
            }
        })
        .map_err(|error| refused(&error))?;
    let out = match fetch(&client, handle, &outcome, args.out.as_deref(), &scene.name) {
        Ok(Some(out)) => out,
        other => return other.map(|_| Exit::of_code(outcome.code)),
    };
    if args.json {
        let path = out.join("summary.json");
        let text = std::fs::read_to_string(&path).map_err(|error| Trouble::file(&path, error))?;
        print(text)?;
    }
    if !quiet {
        eprintln!("{}", out.display());
    }
    Ok(Exit::of_code(outcome.code))
}

/// Fetches what there is, if anything, and says where it went.
fn fetch(
    client: &Client,
    handle: Handle,
    outcome: &Outcome,
    asked: Option<&Path>,
    scene: &str,
) -> Result<Option<PathBuf>, Trouble> {
    let fetched = match outcome.files.is_empty() {
        true => Ok(None),
        false => Folder::of(asked, scene).and_then(|out| {
            let done = client.fetch(handle, outcome, &out.path).map_err(|error| refused(&error));
            done.map(|_| Some(out.path.clone())).inspect_err(|_| out.forget())
        }),
    };
    client.enough(handle);
    fetched
}

fn refused(error: &LinkError) -> Trouble {
    let exit = match error {
        LinkError::Silent { .. } | LinkError::Connect { .. } | LinkError::Forgotten { .. } => {
            Exit::Unreachable
        }
        LinkError::File { .. } => Exit::File,
        LinkError::Refused(_) | LinkError::Path { .. } => Exit::Usage,
        LinkError::Listen { .. }
        | LinkError::Spawn { .. }
        | LinkError::Thread(_)
        | LinkError::Wire(_) => Exit::Failed,
    };
    Trouble::new(exit, error)
}

/// A number that no other submission has: the process and the moment.
fn ticket() -> u64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let nanoseconds = since.map_or(0, |since| since.as_nanos() as u64);
    cullet_geometry::math::scramble(nanoseconds ^ (u64::from(std::process::id()) << 32))
}

#[cfg(test)]
mod tests {
    use super::{MANIFEST, bundle, pack};
    use cullet_coordinator::scene::{load, load_bundle};

    fn sent(manifest: &str) -> Vec<(String, Vec<u8>)> {
        vec![(MANIFEST.to_owned(), manifest.into()), ("files/0".to_owned(), Vec::new())]
    }

    #[test]
    fn a_scene_may_use_files_outside_its_folder() {
        let folder = std::env::temp_dir().join(format!("cullet-pack-{}", std::process::id()));
        let inner = folder.join("inner");
        std::fs::create_dir_all(&inner).expect("a folder");
        let text = "include = [\"../shared.toml\"]\n";
        std::fs::write(inner.join("scene.toml"), text).expect("a scene");
        let shared = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/pair/scene.toml");
        std::fs::copy(shared, folder.join("shared.toml")).expect("a file to include");
        let scene = load(&inner, &[]);
        std::fs::remove_dir_all(&folder).ok();
        let scene = scene.expect("it loads");
        let files = pack(&scene);
        let safe = |path: &String| cullet_coordinator::link::check_path(path).is_ok();
        assert!(files.len() > 2 && files.iter().all(|(path, _)| safe(path)));
        let Ok(bundle) = bundle(files, Vec::new()) else { panic!("it unpacks") };
        let again = load_bundle(&bundle).expect("it loads from the bundle");
        assert_eq!(again.bodies.len(), scene.bodies.len());
    }

    #[test]
    fn a_name_that_leads_elsewhere_is_refused() {
        assert!(bundle(sent("pot\nscene/scene.toml\nscene/scene.toml\n"), Vec::new()).is_ok());
        for name in ["", "..", "../pot", "/tmp/pot", "a/b"] {
            let manifest = format!("{name}\nscene/scene.toml\nscene/scene.toml\n");
            assert!(bundle(sent(&manifest), Vec::new()).is_err(), "{name}");
        }
        assert!(bundle(sent("pot\nscene/scene.toml\n"), Vec::new()).is_err());
    }
}
