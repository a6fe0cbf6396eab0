//! A worker process with a stand-in solver, for tests: what a job costs and gives is written in its
//! settings, so that no physics is needed to try the pool.

use cullet_geometry::{Sheet, Solid, TriMesh, Vec3};
use cullet_model::{Fragment, Fragmentation, Report};
use cullet_proto::transport::Patience;
use cullet_proto::{FractureJob, Verdict};
use cullet_worker::{JobCommand, JobControl, WorkerConfig, run_with, serve_jobs};
use std::sync::Arc;
use std::time::{Duration, Instant};

fn main() {
    if std::env::args().nth(1).as_deref() == Some("job") {
        return serve_jobs(1, Arc::new(solve)).expect("a job process");
    }
    if std::env::var_os("CULLET_LOG").is_some() {
        let levels = tracing_subscriber::EnvFilter::from_env("CULLET_LOG");
        let logs = tracing_subscriber::fmt().with_env_filter(levels).json().flatten_event(true);
        logs.with_writer(std::io::stderr).init();
    }
    let mut config = WorkerConfig { patience: Patience::test(), ..WorkerConfig::default() };
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--connect" => config.connect.extend(args.next()),
            "--name" => config.name = args.next().unwrap_or_default(),
            "--threads" => config.threads = args.next().and_then(|n| n.parse().ok()).unwrap_or(1),
            "--parent-watch" => config.parent_watch = true,
            "--patient" => config.patience = Patience::production(),
            other => assert_eq!(other, "worker", "unknown argument"),
        }
    }
    let exe = std::env::current_exe().expect("a path");
    config.job = Some(JobCommand { exe, args: vec!["job".into()], memory: Some(256 << 20) });
    if let Err(error) = run_with(config, Arc::new(solve)) {
        eprintln!("{error}");
        std::process::exit(1);
    }
}

/// A body whose mesh has so many MB.
fn bulk(size: u32) -> Solid {
    let count = size * 25_000;
    let vertices = (0..count).map(|k| Vec3::new(f64::from(k), 0.5, -1.0)).collect();
    let triangles = (0..count - 1_000).map(|k| [k, k + 1, k + 2]).collect();
    Solid::outer(TriMesh { vertices, triangles })
}

/// Takes `max_steps` ms; gives `seed % 7` fragments, each the body itself.
fn solve(job: &FractureJob, watch: &JobControl) -> Option<Verdict> {
    if job.solver == "die" {
        std::process::abort();
    }
    if job.solver == "drag" {
        let parent = std::os::unix::process::parent_id().to_string();
        let killed = std::process::Command::new("kill").args(["-9", &parent]).status();
        assert!(killed.is_ok_and(|status| status.success()));
    }
    if job.solver == "gulp" {
        // Never touched, so that nobody who looks at what is held sees it.
        let gulp = vec![0u8; 1 << 30];
        assert_eq!(std::hint::black_box(gulp).len(), 1 << 30);
    }
    if job.solver.starts_with("linger") {
        // The first time for ever; a file tells that it has begun.
        let begun = std::env::temp_dir().join(format!("cullet-{}", job.solver));
        let first = std::fs::File::create_new(begun).is_ok();
        while first && !watch.cancelled() {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
    let mut hoard = Vec::new();
    while job.solver == "hoard" && !watch.cancelled() {
        hoard.push(vec![1u8; 8 << 20]);
        std::thread::sleep(Duration::from_millis(5));
    }
    let until = Instant::now() + Duration::from_millis(u64::from(job.problem.settings.max_steps));
    while Instant::now() < until {
        if watch.cancelled() && job.solver != "hang" {
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let fragment = |k: u64| Fragment {
        solid: (**job.problem.body.solid().expect("a solid")).clone(),
        hulls: Vec::new(),
        velocity: job.problem.impacts[0].normal * k as f64,
        spin: job.problem.impacts[0].point,
        sheet: Sheet::default(),
    };
    let mut fragments: Vec<_> = (0..job.problem.seed % 7).map(fragment).collect();
    if let Some(size) = job.solver.strip_prefix("bulk") {
        let size = size.strip_prefix('-').and_then(|size| size.parse().ok()).unwrap_or(50);
        fragments = vec![Fragment { solid: bulk(size), ..fragment(1) }];
    }
    let report =
        Report { solver: job.solver.clone(), steps: job.problem.seed, ..Report::default() };
    Some(Fragmentation { fragments, report, ..Fragmentation::default() }.into())
}
