//! A specimen, from the wire to its result.

use crate::families::SPECIMEN_FAMILIES;
use cullet_geometry::Quat;
use cullet_model::strength::EVEN;
use cullet_proto::specimen::{
    Ending, Price, SpecimenJob, SpecimenOutcome, SpecimenProblem, SpecimenResult,
};
use cullet_specimen::{SpecimenFamily, SpecimenRun};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// Solves a specimen with the threads that it asks for. What goes wrong is how it ended.
#[must_use]
pub fn solve(job: &SpecimenJob) -> SpecimenResult {
    solve_with(job, SPECIMEN_FAMILIES)
}

/// The same by the families of a table.
#[must_use]
pub fn solve_with(job: &SpecimenJob, families: &[SpecimenFamily]) -> SpecimenResult {
    let threads = job.0.settings.threads.clamp(1, 256) as usize;
    let start = Instant::now();
    let work = || catch_unwind(AssertUnwindSafe(|| outcome(problem_of(job), families)));
    let crashed = |text: String| SpecimenOutcome::ended(Ending::Crashed(text));
    let outcome = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => {
            pool.install(work).unwrap_or_else(|_| crashed("the solver panicked".to_owned()))
        }
        Err(error) => crashed(error.to_string()),
    };
    let wall = start.elapsed().as_secs_f64();
    SpecimenResult { outcome, price: Price { wall, cpu: cpu_time(), peak: peak_memory() } }
}

fn outcome(problem: SpecimenProblem, families: &[SpecimenFamily]) -> SpecimenOutcome {
    match SpecimenRun::begin(problem, families) {
        Ok(run) => run.finished(),
        Err(unfit) => SpecimenOutcome::ended(Ending::Refused(unfit.to_string())),
    }
}

/// The problem of a job. The wire has no infinity, and its turns have a length of about 1.
fn problem_of(job: &SpecimenJob) -> SpecimenProblem {
    let mut problem = job.0.clone();
    problem.body.turn = Quat::new_normalize(problem.body.turn.into_inner());
    let strength = &mut problem.matter.strength;
    if strength.weibull >= EVEN {
        strength.weibull = f64::INFINITY;
    }
    problem
}

/// Ticks a second of the times in `/proc`: the same on every Linux.
const TICKS: f64 = 100.0;

/// Processor time of this process so far \[s\]; 0 where the system does not tell.
fn cpu_time() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let rest = text.rsplit(')').next().unwrap_or_default();
    let fields: Vec<f64> = rest.split_whitespace().map(|f| f.parse().unwrap_or(0.0)).collect();
    // After the name: the state, ten more, then user and system time.
    fields.get(11..13).map_or(0.0, |times| times.iter().sum::<f64>() / TICKS)
}

/// Most memory of this process so far \[bytes\]; 0 where the system does not tell.
fn peak_memory() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let size = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
    size.unwrap_or(0) * 1024
}
