//! A pool of real worker processes that only sleep: overhead per job and efficiency.
//!
//! `cargo build --release -p cullet-worker --examples` and then
//! `target/release/examples/sleepers [MILLIS JOBS_PER_WORKER WORKERS...]` prints a CSV; without
//! arguments, 1 s jobs, ten a worker, for 1 to 64 workers; with `bulk`, results of 50 MB; with
//! `storm`, 64 workers that come and are killed. The workers are `stub` beside it.

use cullet_coordinator::link::{Ending, Pool, PoolConfig, Share, SpawnConfig};
use cullet_proto::FractureJob;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn job(seed: u64, millis: u32) -> FractureJob {
    let mut job = FractureJob::smallest("sleep", seed);
    job.settings.max_steps = millis;
    job
}

fn measure(millis: u32, each: u64, workers: usize) -> Result<(), Box<dyn std::error::Error>> {
    let spawn = Some(SpawnConfig::new(stub()?, workers, 1));
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

/// Results of 50 MB through one pool.
fn bulk(jobs: u64, workers: usize) -> Result<(), Box<dyn std::error::Error>> {
    println!("workers,results,mib_each,wall_s,mib_per_s,resent,damaged,peak_mib");
    let spawn = Some(SpawnConfig::new(stub()?, workers, 1));
    let pool = Pool::start(PoolConfig { spawn, ..PoolConfig::default() })?;
    let run = pool.run(Share::default());
    let mut mib = 0.0;
    let since = Instant::now();
    for seed in 0..jobs {
        run.open(&FractureJob::smallest("bulk", seed));
    }
    for _ in 0..jobs {
        let (_, settlement) = run.settled(Duration::from_secs(120)).ok_or("no result")?;
        let Ending::Verdict(verdict) = settlement.ending else {
            return Err(format!("{:?}", settlement.ending).into());
        };
        mib = verdict.encode()?.len() as f64 / f64::from(1 << 20);
    }
    let (real, stats) = (since.elapsed().as_secs_f64(), pool.stats());
    let (rate, resent, damaged) = (mib * jobs as f64 / real, stats.jobs.resent, stats.damaged);
    let peak = peak();
    println!("{workers},{jobs},{mib:.1},{real:.2},{rate:.0},{resent},{damaged},{peak}");
    Ok(())
}

/// Most memory held so far \[MiB\], where the system says.
fn peak() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|l| l.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()).unwrap_or(0) >> 10
}

fn stub() -> std::io::Result<PathBuf> {
    Ok(std::env::current_exe()?.with_file_name("stub"))
}

/// Workers that come and are killed after 2 to 6 s, each replaced at once; jobs of 20 ms flow.
fn storm(places: u64, seconds: u64) -> Result<(), Box<dyn std::error::Error>> {
    println!("workers,seconds,joined,killed,jobs,resent,deaths,charged,abandoned,alarms,last_s");
    let pool = Pool::start(PoolConfig::default())?;
    let run = pool.run(Share::default());
    let (mut joined, mut killed, mut opened, mut settled, mut draw) = (0u64, 0u64, 0, 0, 1u64);
    let mut crew: Vec<(Child, Instant)> = Vec::new();
    let since = Instant::now();
    let over = Duration::from_secs(seconds);
    let (mut abandoned, mut last, mut deaths, mut charged) = (0, Duration::ZERO, 0, 0);
    while since.elapsed() < over || settled < opened {
        for (child, _) in crew.iter_mut().filter(|(_, until)| *until < Instant::now()) {
            child.kill()?;
            child.wait()?;
            killed += 1;
        }
        crew.retain(|(_, until)| *until >= Instant::now());
        while (crew.len() as u64) < places {
            draw = draw.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            joined += 1;
            let name = format!("s{joined}");
            let child = Command::new(stub()?)
                .args(["worker", "--connect", pool.endpoint(), "--name", &name, "--parent-watch"])
                .stdin(Stdio::piped())
                .spawn()?;
            let life = Duration::from_millis(2_000 + (draw >> 33) % 4_000);
            crew.push((child, Instant::now() + life));
        }
        while since.elapsed() < over && opened < settled + 4 * places {
            run.open(&job(opened, 20));
            opened += 1;
        }
        while let Some((_, settlement)) = run.settled(Duration::from_millis(5)) {
            settled += 1;
            for attempt in &settlement.tries {
                deaths += u64::from(attempt.how.starts_with("Down"));
                charged += u64::from(attempt.how == "Down");
            }
            if !matches!(settlement.ending, Ending::Verdict(_)) {
                abandoned += 1;
                eprintln!("{settlement:#?}");
            }
            last = since.elapsed();
        }
        if since.elapsed() > over + Duration::from_secs(60) {
            return Err(format!("{settled} of {opened} settled").into());
        }
    }
    let stats = pool.stats();
    let (resent, alarms, last) = (stats.jobs.resent, stats.alarms, last.as_secs_f64());
    for (child, _) in &mut crew {
        child.kill()?;
        child.wait()?;
    }
    let counts = format!("{joined},{killed},{settled},{resent},{deaths},{charged}");
    println!("{places},{seconds},{counts},{abandoned},{alarms},{last:.1}");
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    match std::env::args().nth(1).as_deref() {
        Some("bulk") => return bulk(20, 2),
        Some("storm") => return storm(64, 30),
        _ => {}
    }
    println!("workers,job_ms,jobs,wall_s,efficiency,overhead_ms_per_job,start_s,resent");
    let args: Vec<u64> =
        std::env::args().skip(1).map(|arg| arg.parse()).collect::<Result<_, _>>()?;
    let (millis, each, workers) = match &args[..] {
        [millis, each, workers @ ..] => (*millis as u32, *each, workers.to_vec()),
        _ => (1_000, 10, vec![1, 2, 4, 8, 16, 32, 64]),
    };
    workers.iter().try_for_each(|workers| measure(millis, each, *workers as usize))
}
