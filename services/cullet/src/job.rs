//! The process that a worker keeps for its jobs, and the same for one job in a file.

use crate::args::{self, Memory};
use crate::exit::{CommandError, Exit, print};
use cullet_model::SolveOutcome;
use cullet_proto::Verdict;
use cullet_worker::{JobCommand, replay, serve_jobs, solve};
use std::sync::Arc;

/// How a worker starts that process.
pub(crate) fn command(threads: u16, memory: Memory) -> Result<JobCommand, CommandError> {
    let exe = std::env::current_exe().map_err(|error| CommandError::new(Exit::Broken, error))?;
    let args = vec!["job".to_owned(), "--threads".to_owned(), threads.to_string()];
    Ok(JobCommand { exe, args, memory: memory.bytes(1) })
}

pub(crate) fn job(args: &args::JobArgs) -> Result<Exit, CommandError> {
    let threads = usize::from(args.threads);
    let Some(file) = &args.file else {
        serve_jobs(threads, Arc::new(solve::by_table))
            .map_err(|error| CommandError::new(Exit::Broken, error))?;
        return Ok(Exit::Done);
    };
    cullet_files::regular::open(file).map_err(|error| CommandError::file(file, error))?;
    let (digest, verdict) =
        replay(file, threads).map_err(|error| CommandError::file(file, error))?;
    let told = match verdict {
        Verdict::Solved(SolveOutcome::Deformed(body)) => format!("deformed, {:.3e} J", body.work),
        Verdict::Solved(outcome) => format!("{} fragments", outcome.bodies()),
        Verdict::Refused { solver, text } => format!("{solver} refuses: {text}"),
        Verdict::Failed { solver, text } => format!("{solver} failed: {text}"),
        Verdict::Measured(result) => format!("a specimen: {:?}", result.outcome.ending),
        Verdict::Moved(outcome) => format!("a window, {} frames", outcome.frames.len()),
    };
    print(format!("{told}; result {digest}\n"))?;
    Ok(Exit::Done)
}
