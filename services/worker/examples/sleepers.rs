//! A pool of real worker processes that only sleep: overhead per job and efficiency.
//!
//! `cargo build --release -p cullet-worker --examples` and then
//! `target/release/examples/sleepers [MILLIS JOBS_PER_WORKER WORKERS...]` prints a CSV; without
//! arguments, 1 s jobs, ten a worker, for 1 to 64 workers. The workers are `stub` beside it.

use cullet_coordinator::link::{Ending, Pool, PoolConfig, Share, SpawnConfig};
use cullet_proto::FractureJob;
use std::time::{Duration, Instant};

fn job(seed: u64, millis: u32) -> FractureJob {
    let mut job = FractureJob::smallest("sleep", seed);
    job.settings.max_steps = millis;
    job
}

fn measure(millis: u32, each: u64, workers: usize) -> Result<(), Box<dyn std::error::Error>> {
    let exe = std::env::current_exe()?.with_file_name("stub");
    let spawn = Some(SpawnConfig::new(exe, workers, 1));
    let pool = Pool::start(PoolConfig { spawn, ..PoolConfig::default() })?;
    let run = pool.run(Share::default());
    let since = Instant::now();
    while pool.stats().workers < workers as u64 {
        std::thread::sleep(Duration::from_millis(5));
    }
    // One job each first, so that every worker has its job process.
    let warm: Vec<_> = (0..workers as u64).map(|k| run.open(&job(1 << 32 | k, 500))).collect();
    for _ in &warm {
        run.settled(Duration::from_secs(60)).ok_or("no worker in a minute")?;
    }
    let start = since.elapsed();
    let since = Instant::now();
    let jobs = each * workers as u64;
    for seed in 0..jobs {
        run.open(&job(seed, millis));
    }
    for _ in 0..jobs {
        let (_, settlement) = run.settled(Duration::from_secs(60)).ok_or("no job in a minute")?;
        if !matches!(settlement.ending, Ending::Verdict(_)) {
            return Err(format!("{settlement:?}").into());
        }
    }
    let real = since.elapsed().as_secs_f64();
    let ideal = f64::from(millis) * 1e-3 * each as f64;
    let (efficiency, overhead) = (ideal / real, (real - ideal) / jobs as f64 * 1e3);
    let (start, resent) = (start.as_secs_f64(), pool.stats().jobs.resent);
    println!(
        "{workers},{millis},{jobs},{real:.3},{efficiency:.4},{overhead:.3},{start:.1},{resent}"
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("workers,job_ms,jobs,wall_s,efficiency,overhead_ms_per_job,start_s,resent");
    let args: Vec<u64> =
        std::env::args().skip(1).map(|arg| arg.parse()).collect::<Result<_, _>>()?;
    let (millis, each, workers) = match &args[..] {
        [millis, each, workers @ ..] => (*millis as u32, *each, workers.to_vec()),
        _ => (1_000, 10, vec![1, 2, 4, 8, 16, 32, 64]),
    };
    workers.iter().try_for_each(|workers| measure(millis, each, *workers as usize))
}
