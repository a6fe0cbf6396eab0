//! A pool of real worker processes that only sleep: overhead per job and efficiency.
//!
//! `cargo build --release -p cullet-worker --examples` and then
//! `target/release/examples/sleepers [MILLIS JOBS_PER_WORKER WORKERS...]` prints a CSV; without
//! arguments, 1 s jobs, ten a worker, for 1 to 64 workers, and 1 000 tiny ones through 8; with
//! `bulk`, results of 50 MB; with `storm [WORKERS]`, 64 workers or so many that come and are
//! killed. It ends with 1 and in words where a figure misses its gate, a job is given up or settles
//! out of turn, two results differ, or one is sent again though nobody was killed. The workers are
//! `stub` beside it. Memory is the most that was held at one time: by this process, which is the
//! coordinator, by one worker, and by a worker's job process.

use cullet_pool::{JobEnding, Pool, PoolConfig, Share, SpawnConfig};
use cullet_proto::{FractureJob, JobId};
use std::collections::VecDeque;
use std::fmt::Display;
use std::path::PathBuf;
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

/// Least of the workers' time that is spent on jobs of a second or more.
const EFFICIENCY: f64 = 0.95;
/// Fewest jobs of no length a second, of a thousand or more, through eight workers.
const RATE: f64 = 1_000.0;

type Done = Result<(), Box<dyn std::error::Error>>;

fn job(seed: u64, millis: u32) -> FractureJob {
    let mut job = FractureJob::smallest("sleep", seed);
    job.problem.settings.max_steps = millis;
    job
}

fn measure(millis: u32, each: u64, workers: usize) -> Done {
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
    let opened: Vec<_> = (0..jobs).map(|seed| run.open(&job(seed, millis))).collect();
    for id in opened {
        let (settled, settlement) = run.settled(Duration::from_secs(60)).ok_or("no job")?;
        in_turn(settled, Some(id))?;
        if !matches!(settlement.ending, JobEnding::Verdict(_)) {
            return Err(format!("{settlement:?}").into());
        }
    }
    let real = since.elapsed().as_secs_f64();
    let ideal = f64::from(millis) * 1e-3 * each as f64;
    let (efficiency, overhead) = (ideal / real, (real - ideal) / jobs as f64 * 1e3);
    let (start, stats) = (start.as_secs_f64(), pool.stats());
    let resent = stats.jobs.resent;
    let memory = memory(&pool.pids());
    println!(
        "{workers},{millis},{jobs},{real:.3},{efficiency:.4},{overhead:.3},{start:.1},{resent},\
         {memory}"
    );
    none("sent again", resent)?;
    none("results that differ", stats.alarms)?;
    let rate = jobs as f64 / real;
    if millis >= 1_000 && efficiency < EFFICIENCY {
        return Err(format!("efficiency {efficiency:.4}, and {EFFICIENCY} is the gate").into());
    }
    if millis == 0 && jobs >= 1_000 && workers == 8 && rate < RATE {
        return Err(format!("{rate:.0} jobs a second, and {RATE} is the gate").into());
    }
    Ok(())
}

/// Jobs settle in the order in which they were opened.
fn in_turn(settled: JobId, due: Option<JobId>) -> Done {
    match due == Some(settled) {
        true => Ok(()),
        false => Err(format!("{settled} has settled, and {due:?} was due").into()),
    }
}

/// There must be none of these.
fn none(what: &str, count: u64) -> Done {
    if count == 0 { Ok(()) } else { Err(format!("{count} {what}, and none should be").into()) }
}

/// Most memory held so far \[MiB\]: here, by one of these workers, by one of their job processes.
fn memory(workers: &[u32]) -> String {
    let all = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let ids = all.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let jobs: Vec<u32> =
        ids.filter(|id| status(id, "PPid:").is_some_and(|id| workers.contains(&id))).collect();
    let most = |ids: &[u32]| ids.iter().map(peak).fold(0.0, f64::max);
    format!("{:.1},{:.1},{:.1}", peak(&"self"), most(workers), most(&jobs))
}

/// Results of 50 MB through one pool.
fn bulk(jobs: u64, workers: usize) -> Done {
    println!("workers,results,mib_each,wall_s,mib_per_s,resent,damaged,peak_mib");
    let spawn = Some(SpawnConfig::new(stub()?, workers, 1));
    let pool = Pool::start(PoolConfig { spawn, ..PoolConfig::default() })?;
    let run = pool.run(Share::default());
    let mut mib = 0.0;
    let since = Instant::now();
    let open = |seed| run.open(&FractureJob::smallest("bulk", seed));
    let opened: Vec<_> = (0..jobs).map(open).collect();
    for id in opened {
        let (settled, settlement) = run.settled(Duration::from_secs(120)).ok_or("no result")?;
        in_turn(settled, Some(id))?;
        let JobEnding::Verdict(verdict) = settlement.ending else {
            return Err(format!("{:?}", settlement.ending).into());
        };
        mib = verdict.encode()?.len() as f64 / f64::from(1 << 20);
    }
    let (real, stats) = (since.elapsed().as_secs_f64(), pool.stats());
    let (rate, resent, damaged) = (mib * jobs as f64 / real, stats.jobs.resent, stats.damaged);
    let peak = peak(&"self");
    println!("{workers},{jobs},{mib:.1},{real:.2},{rate:.0},{resent},{damaged},{peak:.0}");
    none("sent again", resent)?;
    none("damaged", damaged)?;
    none("results that differ", stats.alarms)
}

/// Most memory that a process has held so far \[MiB\], where the system says.
fn peak(process: &impl Display) -> f64 {
    f64::from(status(process, "VmHWM:").unwrap_or(0)) / 1024.0
}

fn status(process: &impl Display, what: &str) -> Option<u32> {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(what))?;
    line.split_whitespace().next()?.parse().ok()
}

fn stub() -> std::io::Result<PathBuf> {
    Ok(std::env::current_exe()?.with_file_name("stub"))
}

/// Workers that come and are killed after 2 to 6 s, each replaced at once; jobs of 20 ms flow.
fn storm(places: u64, seconds: u64) -> Done {
    println!("workers,seconds,joined,killed,jobs,resent,deaths,charged,abandoned,alarms,last_s");
    let pool = Pool::start(PoolConfig::default())?;
    let run = pool.run(Share::default());
    let (mut joined, mut killed, mut opened, mut settled, mut draw) = (0u64, 0u64, 0, 0, 1u64);
    let mut due = VecDeque::new();
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
            due.push_back(run.open(&job(opened, 20)));
            opened += 1;
        }
        while let Some((id, settlement)) = run.settled(Duration::from_millis(5)) {
            settled += 1;
            in_turn(id, due.pop_front())?;
            for attempt in &settlement.tries {
                deaths += u64::from(attempt.how.starts_with("Down"));
                charged += u64::from(attempt.how == "Down");
            }
            if !matches!(settlement.ending, JobEnding::Verdict(_)) {
                abandoned += 1;
                eprintln!("{:?}: {:?}", settlement.ending, settlement.tries);
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
    none("abandoned", abandoned)?;
    none("results that differ", alarms)
}

/// One row in a process of its own, for what one has held may stay with it.
fn apart(millis: u64, each: u64, workers: u64) -> Done {
    let numbers = [millis, each, workers].map(|number| number.to_string());
    let status = Command::new(std::env::current_exe()?).arg("row").args(&numbers).status()?;
    let [millis, each, workers] = numbers;
    let row = format!("{each} jobs each of {millis} ms for {workers} workers");
    if status.success() { Ok(()) } else { Err(format!("{row}: {status}").into()) }
}

/// Every row, also where one before it missed its gate.
fn all(rows: impl Iterator<Item = (u64, u64, u64)>) -> Done {
    let told: Vec<_> = rows.map(|(millis, each, workers)| apart(millis, each, workers)).collect();
    told.into_iter().collect()
}

fn main() -> ExitCode {
    match what() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

fn what() -> Done {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let numbers = |from: usize| -> Result<Vec<u64>, std::num::ParseIntError> {
        words.iter().skip(from).map(|word| word.parse()).collect()
    };
    match words.first().map(String::as_str) {
        Some("bulk") => return bulk(20, 2),
        Some("storm") => return storm(numbers(1)?.first().copied().unwrap_or(64), 30),
        Some("row") => {
            let all = numbers(1)?;
            let [millis, each, workers] = all[..] else { return Err("three numbers".into()) };
            return measure(millis as u32, each, workers as usize);
        }
        _ => {}
    }
    println!(
        "workers,job_ms,jobs,wall_s,efficiency,overhead_ms_per_job,start_s,resent,\
         coordinator_mib,worker_mib,job_mib"
    );
    if let [millis, each, workers @ ..] = &numbers(0)?[..] {
        return all(workers.iter().map(|workers| (*millis, *each, *workers)));
    }
    let long = [1, 2, 4, 8, 16, 32, 64].map(|workers| (1_000, 10, workers));
    all(long.into_iter().chain([(0, 125, 8)]))
}
