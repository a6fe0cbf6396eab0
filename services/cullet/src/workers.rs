//! Commands about the workers of a coordinator.

use crate::args;
use crate::client::{NAME, ask, connect, print_json};
use crate::doctor;
use crate::exit::{CommandError, Exit, print, refused};
use crate::shown::{cell, shown};
use cullet_proto::keys::UserVerb;
use cullet_proto::service::{Drain, Drained, Workers};

pub(crate) fn workers(args: &args::Ps) -> Result<Exit, CommandError> {
    let workers = connect(&args.place)?.workers().map_err(|error| refused(&error))?;
    let said = Workers { workers, next: String::new() };
    if args.place.who.json {
        print_json(&said)?;
        return Ok(Exit::Done);
    }
    let mut text = format!(
        "{:<24} {:<8} {:>7} {:>10} {:>6}  {:<8} {}\n",
        "WORKER", "STATE", "THREADS", "MIB A JOB", "DONE", "BUILD", "JOB"
    );
    for w in &said.workers {
        let state = match (w.up, w.drained) {
            (false, _) => "away",
            (true, true) => "drained",
            (true, false) if w.jobs.is_empty() => "idle",
            (true, false) => "busy",
        };
        let jobs: Vec<String> =
            w.jobs.iter().map(|job| shown(job).chars().take(8).collect()).collect();
        let memory = w.memory.map_or_else(|| "any".to_owned(), |bytes| (bytes >> 20).to_string());
        let row = format!(
            "{:<24} {state:<8} {:>7} {memory:>10} {:>6}  {:<8} {}",
            cell(&w.name, NAME),
            w.threads,
            w.done,
            cell(&w.build, NAME),
            jobs.join(" ")
        );
        text += row.trim_end();
        text.push('\n');
    }
    text.extend(doctor::twins(&said.workers).map(|line| shown(&line).into_owned() + "\n"));
    print(text)?;
    Ok(Exit::Done)
}

pub(crate) fn drain(args: &args::DrainArgs) -> Result<Exit, CommandError> {
    let question = Drain { worker: args.worker.clone() };
    let said: Drained = ask(&connect(&args.place)?, UserVerb::Drain, &question)?;
    let (name, lives) = (shown(&args.worker), said.sessions.join(", "));
    let lives = shown(&lives);
    match said.sessions.len() {
        _ if args.place.who.json => print_json(&said)?,
        0 => print(format!(
            "{name} is away: should it come back it gets no more jobs; another of its name does\n"
        ))?,
        1 => print(format!("{name} gets no more jobs\n"))?,
        n => print(format!("{n} are called {name} ({lives}): none of them gets more jobs\n"))?,
    }
    Ok(Exit::Done)
}
