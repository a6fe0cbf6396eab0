//! Cullet simulates things that break. A rigid-body world runs; when a hit is hard enough, a worker
//! computes what it does to the body that was hit, and closed fragments take the body's place. Mass
//! and momentum are kept, the energy of the cracks is paid for, and the whole run is recorded. The
//! same scene with the same seed gives the same bits, whatever the number of workers.
//!
//! This crate is for programs that use Cullet; the program `cullet` is made from it too.
//!
//! | to | use |
//! |---|---|
//! | read a scene and see what is wrong with it | [`Scene`] |
//! | run it on this machine | [`run()`], or [`LocalPool`] for several runs |
//! | read what a run recorded | [`Recording`] |
//! | write it for Blender, Houdini, Unreal or a browser | [`export()`] |
//! | have it run by a farm, and fetch the result | [`Client`] |
//!
//! # A short program
//!
//! Throw the ball of a scene at three speeds and count the pieces:
//!
//! ```
//! use cullet::{LocalPool, LocalWorkers, RunOptions, Scene};
//! use std::sync::atomic::AtomicBool;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let scene = "../../tests/corpus/ball.toml";
//! # let folder = tempfile::tempdir()?;
//! # let runs = folder.path();
//! let pool = LocalPool::start(&LocalWorkers::default())?;
//! let mut counts = Vec::new();
//! for speed in [2, 8, 32] {
//!     let set = [
//!         format!("body.ball.velocity=[0, 0, -{speed}]"), // [m/s]
//!         "fracture.solver=geometric".to_owned(),         // sampled: quick
//!     ];
//!     let scene = Scene::load(scene, &set)?;
//!     let out = runs.join(speed.to_string());
//!     let stop = AtomicBool::new(false);
//!     let options = RunOptions::new(&out, &stop);
//!     let outcome = pool.run(&scene, &options, &mut |_| {})?;
//!     counts.push(outcome.summary.fragments);
//! }
//! assert!(counts[0] < counts[2], "{counts:?}");
//! # Ok(())
//! # }
//! ```
//!
//! `services/cullet/examples` has five more, for everyday tasks.
//!
//! # Units, frames and errors
//!
//! All quantities are in SI units: metres, kilograms, seconds, newtons, joules; each item says its
//! own in brackets. Gravity is along −z unless the scene sets it. A body's own frame has its origin
//! at the centre of mass; a [`PoseRow`] leads from it to the world. Triangles are counter-clockwise
//! seen from outside.
//!
//! Every error is a typed enum that names the file, value or endpoint. A scene reports all that is
//! wrong with it at once ([`SceneErrors`]). What a solver declines or fails at is no error of the
//! run: it is a verdict, and recorded in [`Recording::reports`].
//!
//! # The crates below
//!
//! The types of this page come from crates that can be used by themselves: [`scene`], [`record`],
//! [`picture`] (stills and films of a recording), [`geometry`], [`pool`], [`coordinator`],
//! [`worker`], [`lab`] (benchmarks), [`document`] and [`proto`]. ARCHITECTURE.md in the repository
//! says what each holds; docs/scene.md lists every key of a scene, docs/protocol.md what a client
//! may ask in any language.

mod build;
mod local;
mod taken;

pub use build::describe_version;
pub use taken::{is_free_to_fetch, is_taken};

pub use local::{LocalPool, LocalRunError, LocalWorkers, run, spare_cores};

/// A scene: read from a file, a folder or text, checked, and ready to run or to submit.
///
/// # Example
///
/// ```
/// use cullet::Scene;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// // A file or its folder, with values set as `cullet run --set` does.
/// let scene = Scene::load("../../scenes/pot", &["world.seed=7".to_owned()])?;
/// assert_eq!((scene.name.as_str(), scene.world.seed), ("pot", 7));
/// let masses = scene.bodies.iter().map(|body| body.volume * body.material.density);
/// assert!(masses.sum::<f64>() > 1.0); // [kg]
///
/// // Everything that is wrong is reported at once, each with its place.
/// let wrong = "[world]\nduration = -1\n[[body]]\nname = \"a\"\nmaterial = \"gold\"";
/// let errors = Scene::parse("wrong", wrong, &[]).unwrap_err().errors;
/// assert!(errors.len() >= 3, "{errors:?}");
/// assert!(errors.iter().any(|error| error.path == "world.duration"));
/// # Ok(())
/// # }
/// ```
///
#[doc(inline)]
pub use cullet_scene::Scene;
#[doc(inline)]
pub use cullet_scene::{SceneBody, SceneMaterial};

#[doc(inline)]
pub use cullet_document::{Bundle, SceneError, SceneErrorKind, SceneErrors};

#[doc(inline)]
pub use cullet_pool::SpawnConfig;
#[doc(inline)]
pub use cullet_run::{News, Outcome, Position, RunAgain, RunError, RunOptions};

/// What a run recorded: bodies and their meshes, poses, events, job reports, the summary.
///
/// # Example
///
/// ```
/// use cullet::Recording;
/// use cullet::messages::EventKind;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("run.mcap");
/// # cullet::record::synthetic::run(&path, &cullet::record::synthetic::meta())?;
/// // A finished recording, or what is there of one whose writer was killed.
/// let recording = Recording::open(&path)?;
/// assert!(recording.complete);
/// let summary = recording.summary();
///
/// let fractures = recording.events.iter().filter(|e| e.kind() == EventKind::Fractured);
/// let when = fractures.map(|event| event.time).next().ok_or("nothing broke")?; // [s]
///
/// // Where each body is at that time, and its mesh [m] in the world.
/// for row in recording.poses_at(when) {
///     let body = recording.body(row.id).ok_or("a body without a birth")?;
///     let solid = recording.mesh(body)?.transformed(&row.pose);
///     assert!((solid.volume() - body.volume).abs() < 1e-9 * body.volume);
/// }
/// # assert!(summary.fragments > 0 && !recording.reports.is_empty());
/// # Ok(())
/// # }
/// ```
///
#[doc(inline)]
pub use cullet_record::Recording;
#[doc(inline)]
pub use cullet_record::{FragmentMass, PoseRow, RecordError, SheetMoment, Summary};

/// Writes a recording as a file of another program, whose ending says which: `.glb`, `.usda` or
/// `.csv`.
///
/// # Example
///
/// ```
/// use cullet::{ExportOptions, Recording, export};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("run.mcap");
/// # cullet::record::synthetic::run(&path, &cullet::record::synthetic::meta())?;
/// let recording = Recording::open(&path)?;
/// let options = ExportOptions { fps: 30.0, ..ExportOptions::default() };
/// let report = export(&recording, &options, &path.with_extension("glb"))?;
/// assert_eq!(report.bodies, recording.bodies.len());
/// # Ok(())
/// # }
/// ```
///
#[doc(inline)]
pub use cullet_export::export;
#[doc(inline)]
pub use cullet_export::{ExportError, ExportOptions, ExportReport, Moments, export_pieces};

/// A client of a farm: submits scenes, follows runs, fetches results, lists and cancels.
///
#[doc(inline)]
pub use cullet_pool::LinkError;
/// # Example
///
/// ```
/// use cullet::{Client, Scene, Terms};
/// # use std::sync::{Arc, atomic::{AtomicBool, Ordering}};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # // A farm: a coordinator and a worker, in this process.
/// # let folder = tempfile::tempdir()?;
/// # let pool = Arc::new(cullet::pool::Pool::start(Default::default())?);
/// # let (endpoint, stop) = (pool.endpoint().to_owned(), Arc::<AtomicBool>::default());
/// # let config = cullet::coordinator::ServiceConfig {
/// #     out: Some(folder.path().join("farm")), runs: 1, ..Default::default()
/// # };
/// # let until = Arc::clone(&stop);
/// # let coordinator = std::thread::spawn(move || {
/// #     let store = cullet::coordinator::Store::open(None)?;
/// #     cullet::coordinator::serve(store, &pool, &config, &until, &mut |_| {})
/// # });
/// # let hired = cullet::worker::WorkerConfig {
/// #     exit_when_wedged: false, stop: Arc::clone(&stop),
/// #     ..cullet::worker::WorkerConfig::new(vec![endpoint.clone()], "w1".to_owned())
/// # };
/// # let worker = std::thread::spawn(move || cullet::worker::run(hired));
/// # let set = ["fracture.solver=geometric".to_owned()];
/// # let out = folder.path().join("fetched");
/// // Connects to `cullet coordinator`, such as tcp/127.0.0.1:7447, and sends it a scene.
/// let client = Client::connect(&endpoint)?;
/// let scene = Scene::load("../../tests/corpus/ball.toml", &set)?;
/// let run = client.submit(&scene.bundle(), &Terms::unique())?;
///
/// // Watches it to its end, from the first line of its log on.
/// let info = client.follow(run, 0, |news| {
///     if let Some(position) = news.run.position {
///         println!("{:.3} of {:.3} s", position.time, position.end);
///     }
/// })?;
/// assert_eq!(info.state.word(), "done");
///
/// // Fetches the recording and what lies beside it.
/// let files = client.fetch(&info, &out)?;
/// assert!(files.contains(&out.join("run.mcap")));
///
/// // Lists the runs there. `client.cancel(run)` would have ended this one early.
/// assert_eq!(client.runs()?.len(), 1);
/// client.enough(run);
/// # stop.store(true, Ordering::Relaxed);
/// # coordinator.join().expect("the coordinator")?;
/// # worker.join().expect("the worker")?;
/// # Ok(())
/// # }
/// ```
///
#[doc(inline)]
pub use cullet_pool::client::Client;
#[doc(inline)]
pub use cullet_pool::client::Terms;
#[doc(inline)]
pub use cullet_proto::service::{About, FileInfo, RunInfo, State};

#[doc(inline)]
pub use cullet_geometry::{Pose, Quat, Solid, TriMesh, Vec3};

/// The messages of a recording: bodies, poses, events, reports.
#[doc(inline)]
pub use cullet_proto::recording as messages;

pub use cullet_coordinator as coordinator;
pub use cullet_document as document;
pub use cullet_geometry as geometry;
pub use cullet_lab as lab;
pub use cullet_picture as picture;
pub use cullet_pool as pool;
pub use cullet_proto as proto;
pub use cullet_record as record;
pub use cullet_scene as scene;
pub use cullet_worker as worker;
