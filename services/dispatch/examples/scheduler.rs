//! The scheduler alone under load: what an event costs, by workers and jobs.
//!
//! `cargo run --release -p cullet-dispatch --example scheduler [-- WORKERS JOBS]` prints a CSV.
//! Jobs of about a second in a simulated clock, a hundred runs of three tenants; renewals, results
//! with the next question, a look at the clock every 25 ms. The columns of each kind are medians
//! \[ns\]: how many events of which kind there are depends on the load, and clocks are cheap.

use cullet_dispatch::{Build, Digest, Dispatch, Effect, Event, Job, Millis, Outcome, Prior};
use cullet_dispatch::{Run, Share, Skills, Tenant, Timing, Worker, WorkerName};
use std::collections::BTreeMap;
use std::time::Instant;

const RUNS: u64 = 100;
const TICK: Millis = 25;
const BUILD: Build = Build([1; 32]);
const KINDS: [&str; 5] = ["open", "poll", "renew", "commit", "tick"];

#[derive(Clone, Copy)]
enum Due {
    Done(Job, u64),
    Renew(Job, u64, Millis),
}

struct Load {
    machine: Dispatch,
    /// Of each kind of event, what each took \[ns\].
    spent: [Vec<u32>; KINDS.len()],
    now: Millis,
    /// By time, in the order in which it came to be.
    due: BTreeMap<Millis, Vec<(u64, Due)>>,
    seqs: Vec<u64>,
    granted: u64,
    settled: u64,
    busy: Millis,
}

fn job(k: u64) -> Job {
    let mut name = [0; 32];
    for (at, word) in name.chunks_mut(8).enumerate() {
        let mixed = (k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15 ^ (at as u64) << 7);
        word.copy_from_slice(&mixed.to_be_bytes());
    }
    Job(name)
}

impl Load {
    fn step(&mut self, event: Event) {
        let kind = match event {
            Event::Begin { .. } | Event::Open { .. } => 0,
            Event::Poll { .. } => 1,
            Event::Renew { .. } => 2,
            Event::Commit { .. } => 3,
            _ => 4,
        };
        let since = Instant::now();
        let effects = self.machine.step(self.now, event);
        self.spent[kind].push(since.elapsed().as_nanos() as u32);
        for effect in effects {
            match effect {
                Effect::Grant { worker, job, epoch, .. } => {
                    self.granted += 1;
                    let length = 900 + u64::from(job.0[0]);
                    self.busy += length;
                    let end = self.now + length;
                    // Each third job is long enough for a renewal, at another worker's expense.
                    if job.0[1] < 85 {
                        let due = Due::Renew(job, epoch.0, end);
                        self.later(self.now + length / 2, worker.0, due);
                    } else {
                        self.later(end, worker.0, Due::Done(job, epoch.0));
                    }
                }
                Effect::Settle { .. } => self.settled += 1,
                _ => {}
            }
        }
    }

    fn later(&mut self, at: Millis, worker: u64, due: Due) {
        self.due.entry(at).or_default().push((worker, due));
    }

    fn ask(&mut self, worker: u64, park: bool) {
        let seq = &mut self.seqs[worker as usize];
        *seq += 1;
        let seq = *seq;
        let (worker, name, build, skills) =
            (Worker(worker), WorkerName(worker), BUILD, Skills::ALL);
        self.step(Event::Poll { worker, seq, slots: 1, park, build, skills, name });
    }

    fn happen(&mut self, worker: u64, due: Due) {
        match due {
            Due::Renew(job, epoch, end) => {
                let epoch = cullet_dispatch::Epoch(epoch);
                let by = Worker(worker);
                let (name, build, skills) = (WorkerName(worker), BUILD, Skills::ALL);
                let begun = true;
                self.step(Event::Renew { worker: by, job, epoch, begun, build, skills, name });
                self.later(end, worker, Due::Done(job, epoch.0));
            }
            Due::Done(job, epoch) => {
                let (digest, outcome) = (Digest(job.0), Outcome::Broken);
                let epoch = cullet_dispatch::Epoch(epoch);
                let (name, build, prior) = (WorkerName(worker), BUILD, Prior::Nothing);
                self.step(Event::Commit {
                    worker: Worker(worker),
                    name,
                    job,
                    epoch,
                    build,
                    digest,
                    outcome,
                    prior,
                });
                self.ask(worker, true);
            }
        }
    }
}

fn measure(workers: u64, jobs: u64) {
    let mut load = Load {
        machine: Dispatch::new(Timing::production(), 1),
        spent: Default::default(),
        now: 0,
        due: BTreeMap::new(),
        seqs: vec![0; workers as usize],
        granted: 0,
        settled: 0,
        busy: 0,
    };
    let begun = on_processor();
    for run in 0..RUNS {
        let share = Share { tenant: Tenant(run % 3), priority: (run % 10) as u8 };
        load.step(Event::Begin { run: Run(run), share });
    }
    for k in 0..jobs {
        let (run, need, prior) = (Run(k % RUNS), Skills::NONE, Prior::Nothing);
        load.step(Event::Open { run, job: job(k), need, after: None, prior });
    }
    for worker in 0..workers {
        load.ask(worker, true);
    }
    let mut tick = TICK;
    while load.settled < jobs {
        let next = load.due.first_key_value().map_or(Millis::MAX, |(at, _)| *at);
        if tick <= next {
            load.now = tick;
            tick += TICK;
            load.step(Event::Tick);
        } else if let Some((at, due)) = load.due.pop_first() {
            load.now = at;
            due.into_iter().for_each(|(worker, due)| load.happen(worker, due));
        }
    }
    let events: usize = load.spent.iter().map(Vec::len).sum();
    let processor = (on_processor() - begun) as f64 / events as f64;
    let efficiency = load.busy as f64 / (load.now * workers) as f64;
    let again = load.granted - jobs;
    let kinds = load.spent.map(|mut took| {
        took.sort_unstable();
        took.get(took.len() / 2).map_or_else(String::new, u32::to_string)
    });
    let (kinds, memory) = (kinds.join(","), memory());
    println!("{workers},{jobs},{events},{processor:.0},{kinds},{again},{efficiency:.4},{memory}");
}

/// Time on the processor so far \[ns\], the driver of this example included; where the system says.
fn on_processor() -> u64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace().next().and_then(|word| word.parse().ok()).unwrap_or(0)
}

/// Most memory held so far \[MiB\], where the system says.
fn memory() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|l| l.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()).unwrap_or(0) >> 10
}

fn main() {
    let kinds = KINDS.map(|kind| format!("{kind}_ns")).join(",");
    println!(
        "workers,jobs,events,processor_ns_per_event,{kinds},granted_again,efficiency,peak_mib"
    );
    let args: Vec<u64> = std::env::args().skip(1).filter_map(|arg| arg.parse().ok()).collect();
    if let [workers, jobs] = args[..] {
        return measure(workers, jobs);
    }
    for (workers, jobs) in [
        (1, 1_000),
        (8, 1_000),
        (64, 6_400),
        (10, 10_000),
        (100, 10_000),
        (100, 100_000),
        (1_000, 100_000),
        (10_000, 100_000),
        (100, 1_000_000),
        (1_000, 1_000_000),
        (10_000, 1_000_000),
    ] {
        measure(workers, jobs);
    }
}
