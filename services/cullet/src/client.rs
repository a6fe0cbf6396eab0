//! Commands about the runs of a coordinator.

use crate::args::{self, ConnectArgs};
use crate::exit::{CommandError, Exit, print, refused, unread};
use crate::folder::{Folder, refuse_fetched, refuse_taken};
use crate::progress::{ProgressDisplay, text as place};
use crate::run::read_scene;
use crate::shown::{self, cell, shown};
use crate::{logs, tls};
use cullet::{Client, LinkError, Terms};
use cullet_document::Bundle;
use cullet_proto::keys::UserVerb;
use cullet_proto::service::{self, FileInfo, RunInfo, Runs, State, Which};
use cullet_run::News;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest wait for a run to stop, and how often it is looked at.
const STOPS: Duration = Duration::from_secs(10);
const LOOK: Duration = Duration::from_millis(50);
/// Most letters of a name in a table: `show` has the whole.
pub(crate) const NAME: usize = 40;
/// Before it is reported that a run waits in the queue.
const QUEUED: Duration = Duration::from_secs(3);
/// Before it is reported that a queue is full.
const ROOM: Duration = Duration::from_secs(2);

pub(crate) fn submit(args: &args::SubmitArgs) -> Result<Exit, CommandError> {
    let place = &args.place;
    if args.rest {
        return Err(CommandError::new(Exit::Usage, "--rest is for sweeps, and this is a scene"));
    }
    args.sheet.fits(None)?;
    let scene = read_scene(&args.scene)?;
    // Said before the run and not after it.
    args.out.as_deref().map_or(Ok(()), refuse_taken)?;
    let client = connect(place)?;
    let terms = Terms { priority: args.priority, ..Terms::unique() };
    let waits = (!args.detach).then_some(!place.who.voice.quiet);
    let run = hand_in(&client, &scene.bundle(), terms, waits)?;
    if args.detach {
        return tell_number(&client, run, place);
    }
    if !place.who.voice.quiet {
        logs::say(format!("run {run}"));
    }
    let info = follow(&client, run, 0, place, args.watch)?;
    let out = match bring(&client, &info, args.out.as_deref()) {
        Ok(Some(out)) => out,
        other => return other.map(|_| exit_of(&info)),
    };
    if place.who.json && has_summary(&info) {
        print_summary(&out)?;
    }
    if !place.who.voice.quiet {
        logs::say(out.display());
    }
    Ok(exit_of(&info))
}

/// Hands a run in. `waits`: a full queue is waited for, for as long as it takes, and whether that
/// is told; otherwise for as long as one is patient.
pub(crate) fn hand_in(
    client: &Client,
    bundle: &Bundle,
    mut terms: Terms,
    waits: Option<bool>,
) -> Result<u64, CommandError> {
    terms.room = waits.map(|_| ROOM);
    let mut told = waits != Some(true);
    loop {
        match client.submit(bundle, &terms) {
            Err(LinkError::Busy { .. }) if waits.is_some() => {
                if !std::mem::replace(&mut told, true) {
                    logs::say(format!(
                        "the queue there is full: {} waits for room in it",
                        shown(&bundle.name)
                    ));
                }
            }
            handed => return handed.map_err(|error| refused(&error)),
        }
    }
}

fn tell_number(client: &Client, run: u64, place: &ConnectArgs) -> Result<Exit, CommandError> {
    client.enough(run);
    match place.who.json {
        true => print_json(&Which { run })?,
        false => print(format!("{run}\n"))?,
    }
    Ok(Exit::Done)
}

/// Whether a run has come to its end, or was stopped there.
pub(crate) fn has_summary(info: &RunInfo) -> bool {
    info.files.iter().any(|file| file.name == "summary.json")
}

fn print_summary(out: &Path) -> Result<(), CommandError> {
    let path = out.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|error| CommandError::file(&path, error))?;
    print(text)
}

pub(crate) fn ps(args: &args::Ps) -> Result<Exit, CommandError> {
    let runs = connect(&args.place)?.runs().map_err(|error| refused(&error))?;
    if args.place.who.json {
        print_json(&Runs { runs })?;
        return Ok(Exit::Done);
    }
    let mut text = format!(
        "{:>6}  {:<20} {:<12} {:<9} {:>4}  {:<22} {}\n",
        "RUN", "SCENE", "USER", "STATE", "PRIO", "AT", "SWEEP"
    );
    for run in &runs {
        text += format!(
            "{:>6}  {:<20} {:<12} {:<9} {:>4}  {:<22} {}",
            run.run,
            cell(&run.name, NAME),
            cell(&run.user, NAME),
            run.state.word(),
            run.priority,
            place_of(run),
            shown(&run.sweep)
        )
        .trim_end();
        text.push('\n');
    }
    print(text)?;
    Ok(Exit::Done)
}

/// Where a run is, in a few words.
fn place_of(run: &RunInfo) -> String {
    match (&run.position, run.code) {
        (Some(p), _) => {
            let solving = Some(p.permille / 10).filter(|_| p.permille > 0);
            let solving = solving.map(|percent| format!(", {percent} %"));
            format!("{:.2} of {:.2} s{}", p.time, p.end, solving.unwrap_or_default())
        }
        (None, Some(code)) => format!("code {code}"),
        (None, None) => String::new(),
    }
}

pub(crate) fn show(args: &args::OfRun) -> Result<Exit, CommandError> {
    let info = known(&connect(&args.place)?, args.run)?;
    match args.place.who.json {
        true => print_json(&info)?,
        false => print(told(&info))?,
    }
    Ok(Exit::Done)
}

fn told(run: &RunInfo) -> String {
    let mut lines = vec![
        format!("run {}: {}, {}", run.run, shown(&run.name), run.state.word()),
        format!("  user {}, priority {}, attempt {}", shown(&run.user), run.priority, run.attempt),
    ];
    lines.extend(run.overrides.iter().map(|set| format!("  --set {}", shown(set))));
    if !run.sweep.is_empty() {
        lines.push(format!("  of the sweep {}", shown(&run.sweep)));
    }
    let jobs = run.jobs;
    lines.push(format!(
        "  jobs: {} opened, {} settled, {} of them kept from before, {} sent again",
        jobs.opened, jobs.settled, jobs.kept, jobs.resent
    ));
    if let Some(p) = run.position {
        lines.push(format!("  {}", place(&p)));
    }
    if let (Some(from), Some(to)) = (run.started_ms, run.ended_ms) {
        lines.push(format!("  took {:.1} s", to.saturating_sub(from) as f64 / 1e3));
    }
    lines.extend(run.code.map(|code| format!("  exit code {code}")));
    if !run.text.is_empty() {
        lines.push(format!("  {}", shown::lines(&run.text)));
    }
    let file = |file: &FileInfo| format!("  {}: {} bytes", shown(&file.name), file.length);
    lines.extend(run.files.iter().map(file));
    if run.files.iter().any(|file| file.name == "job.bin") {
        let fetch = "`cullet fetch {} --out there`, then `cullet job there/job.bin`";
        let fetch = fetch.replace("{}", &run.run.to_string());
        lines.push(format!("  the job that was given up is tried again, alone, with {fetch}"));
    }
    lines.join("\n") + "\n"
}

/// A line of a run's log, for programs. Lines count from 0.
#[derive(Serialize)]
struct Said<'a> {
    run: u64,
    line: u64,
    text: &'a str,
}

pub(crate) fn logs(args: &args::OfRun) -> Result<Exit, CommandError> {
    let client = connect(&args.place)?;
    let mut from = 0;
    loop {
        let question = service::Follow { run: args.run, from, wait_ms: 0 };
        let news: service::RunUpdate = ask(&client, UserVerb::Follow, &question)?;
        if news.lines.is_empty() {
            client.enough(args.run);
            return Ok(Exit::Done);
        }
        from = news.next;
        let first = news.next.saturating_sub(news.lines.len() as u64);
        for (line, text) in (first..).zip(&news.lines) {
            match args.place.who.json {
                true => print_json(&Said { run: args.run, line, text })?,
                false => print(shown(text) + "\n")?,
            }
        }
        if unread() {
            client.enough(args.run);
            return Ok(Exit::Done);
        }
    }
}

pub(crate) fn watch(args: &args::OfRun) -> Result<Exit, CommandError> {
    let client = connect(&args.place)?;
    if args.place.who.json {
        let mut trouble = Ok(());
        let info = client.follow(args.run, 0, |news| {
            if trouble.is_ok() {
                trouble = print_json(news);
            }
            if unread() {
                // Nobody reads what would come: as with `head`.
                client.enough(args.run);
                std::process::exit(i32::from(Exit::Done.code()));
            }
        });
        trouble?;
        return Ok(exit_of(&info.map_err(|error| refused(&error))?));
    }
    let info = follow(&client, args.run, 0, &args.place, true)?;
    client.enough(args.run);
    Ok(exit_of(&info))
}

pub(crate) fn wait(args: &args::OfRun) -> Result<Exit, CommandError> {
    let client = connect(&args.place)?;
    // The lines are of no interest: from beyond the last.
    let info = client.follow(args.run, u64::MAX, |_| {}).map_err(|error| refused(&error))?;
    client.enough(args.run);
    if args.place.who.json {
        print_json(&info)?;
    } else if !args.place.who.voice.quiet {
        logs::say(ended(&info));
    }
    Ok(exit_of(&info))
}

/// How a run ended, and why.
fn ended(info: &RunInfo) -> String {
    let text = shown::lines(&info.text);
    let why = if text.is_empty() { text } else { format!(": {text}") };
    format!("run {} is {}{why}", info.run, info.state.word())
}

/// What is done with a run at its coordinator.
type Act = fn(&Client, u64) -> Result<RunInfo, LinkError>;

/// `stops`: what a run is called that the act stops.
pub(crate) fn control(
    args: &args::OfRun,
    act: Act,
    stops: Option<&str>,
) -> Result<Exit, CommandError> {
    let client = connect(&args.place)?;
    let mut info = act(&client, args.run).map_err(|error| refused(&error))?;
    let begun = Instant::now();
    // A run that goes on stops at its next step.
    while stops.is_some() && info.state == State::Running && begun.elapsed() < STOPS {
        std::thread::sleep(LOOK);
        info = known(&client, args.run)?;
    }
    match args.place.who.json {
        true => print_json(&info)?,
        false => {
            // A run that has not stopped yet is as it was.
            let stopping = stops.filter(|_| info.state == State::Running);
            let stopping = stopping.map(|word| format!(", and is being {word}"));
            let state = info.state.word();
            print(format!("run {} is {state}{}\n", info.run, stopping.unwrap_or_default()))?;
        }
    }
    Ok(Exit::Done)
}

pub(crate) fn delete(args: &args::OfRuns) -> Result<Exit, CommandError> {
    let client = connect(&args.place)?;
    let mut exit = Exit::Done;
    for &run in &args.runs {
        // One that does not go does not keep the others.
        match client.delete(run).map_err(|error| refused(&error)) {
            Ok(()) if args.place.who.json => print_json(&Which { run })?,
            Ok(()) => print(format!("run {run} is deleted\n"))?,
            Err(trouble) => {
                logs::error(&trouble);
                exit = exit.worse(trouble.exit);
            }
        }
        if exit == Exit::Unreachable {
            break;
        }
    }
    Ok(exit)
}

/// `cullet fetch RUN`.
pub(crate) fn fetch(args: &args::FetchArgs, run: u64) -> Result<Exit, CommandError> {
    let place = &args.place;
    if !args.set.is_empty() {
        let text = "--set is for sweeps: it says which of their runs are meant";
        return Err(CommandError::new(Exit::Usage, text));
    }
    args.sheet.fits(None)?;
    args.out.as_deref().map_or(Ok(()), refuse_fetched)?;
    let client = connect(place)?;
    let info = match args.follow {
        true => follow(&client, run, 0, place, true)?,
        false => known(&client, run)?,
    };
    let out = bring(&client, &info, args.out.as_deref())?;
    if !info.state.is_over() {
        let state = info.state.word();
        let text = format!("run {run} is {state}: there is nothing to fetch before its end");
        return Err(CommandError::new(Exit::Later, format!("{text} (--follow waits for it)")));
    }
    match out {
        _ if place.who.json => print_json(&info)?,
        Some(out) => print(format!("{}\n", out.display()))?,
        None if place.who.voice.quiet => {}
        None => logs::say(format!("{}; there is nothing to fetch", ended(&info))),
    }
    Ok(exit_of(&info))
}

pub(crate) fn connect(place: &ConnectArgs) -> Result<Client, CommandError> {
    let who = &place.who;
    let link = tls::link(who.tls.as_deref(), &place.connect, who.user.as_deref(), "user")?;
    let patience = Duration::from_secs_f64(who.patience.clamp(0.1, 86_400.0));
    let client = Client::connect_as(&place.connect, &link.rules, patience)
        .and_then(|client| client.with(&who.coordinator, &link.name))
        .map_err(|error| no_link(&link, &error, place))?;
    if link.is_tls() {
        // A denial is silent: it is reported here, and not by whatever is asked next.
        let _about = client.about().map_err(|error| link.trouble(&error, &place.connect))?;
    }
    Ok(client)
}

/// Why there is no link, and what to look at.
fn no_link(link: &tls::LinkConfig, error: &LinkError, place: &ConnectArgs) -> CommandError {
    let trouble = link.trouble(error, &place.connect);
    match error {
        LinkError::Connect { .. } => {
            let folder =
                place.who.tls.as_ref().map(|folder| format!(" --tls {}", folder.display()));
            let (at, tls) = (&place.connect, folder.unwrap_or_default());
            let next =
                format!("is the coordinator running? cullet doctor --connect {at}{tls} checks");
            let other = "--connect or CULLET_CONNECT names another place, --patience tries longer";
            let text = format!("{trouble}\n{next}; {other}");
            trouble.said(text)
        }
        _ => trouble,
    }
}

pub(crate) fn ask<Q: Serialize, A: serde::de::DeserializeOwned>(
    client: &Client,
    verb: UserVerb,
    question: &Q,
) -> Result<A, CommandError> {
    client.question(verb, question).map_err(|error| refused(&error))
}

pub(crate) fn known(client: &Client, run: u64) -> Result<RunInfo, CommandError> {
    client.run(run).map_err(|error| refused(&error))
}

/// Follows a run; `bar`: shows how far it is, where there is a terminal.
pub(crate) fn follow(
    client: &Client,
    run: u64,
    from: u64,
    place: &ConnectArgs,
    bar: bool,
) -> Result<RunInfo, CommandError> {
    let quiet = place.who.voice.quiet;
    let mut progress = ProgressDisplay::new(quiet || !bar);
    let mut queued = Some(Instant::now()).filter(|_| !quiet);
    let info = client.follow(run, from, |news| {
        let waits = news.run.state == State::Queued;
        if queued.take_if(|since| waits && since.elapsed() >= QUEUED).is_some() {
            logs::say(format!("run {run} is queued: others are under way or before it"));
        }
        for line in &news.lines {
            match bar || quiet {
                true => progress.show(&News::Line(line.clone())),
                false => logs::say(shown(line)),
            }
        }
        if let (true, Some(p)) = (bar, news.run.position) {
            progress.show(&News::At(p));
        }
    });
    progress.done();
    info.map_err(|error| refused(&error))
}

/// Fetches what there is, if anything, and says where it went.
pub(crate) fn bring(
    client: &Client,
    info: &RunInfo,
    asked: Option<&Path>,
) -> Result<Option<PathBuf>, CommandError> {
    let fetched = match info.files.is_empty() {
        true => Ok(None),
        false => Folder::to_fetch(asked, &info.name).and_then(|out| {
            let done = client.fetch(info, &out.path).map_err(|error| refused(&error));
            done.map(|_| Some(out.path.clone())).inspect_err(|_| out.forget_fetch())
        }),
    };
    client.enough(info.run);
    fetched
}

/// How the process ends because a run ended so.
pub(crate) fn exit_of(info: &RunInfo) -> Exit {
    let by_state = match info.state {
        State::Done => Exit::Done,
        State::Failed => Exit::Failed,
        State::Stalled => Exit::Stalled,
        State::Cancelled => Exit::Cancelled,
        State::Queued | State::Running | State::Paused => Exit::Done,
    };
    info.code.and_then(Exit::of_run).unwrap_or(by_state)
}

pub(crate) fn print_json<T: Serialize>(said: &T) -> Result<(), CommandError> {
    let text = serde_json::to_string(said);
    print(text.map_err(|error| CommandError::new(Exit::Broken, error))? + "\n")
}
