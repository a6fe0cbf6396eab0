//! The one binary: reads what a person typed, lets the shells do it, says how it went.

mod advice;
mod args;
mod bench;
mod client;
mod doctor;
mod exit;
mod export;
mod files;
mod folder;
mod frontier;
mod illustrator;
mod inspect;
mod job;
mod live;
mod logs;
mod new;
mod openjd;
mod pages;
mod progress;
mod report;
mod run;
mod serve;
mod shipped;
mod shown;
mod signals;
mod sweep;
mod tls;
mod viewers;
mod workers;

use args::{Cli, Command, Log, SceneArgs, Voice, What};
use clap::Parser;
use clap::error::ErrorKind;
use cullet::Client;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let json = logs::as_asked();
    let mut cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return not_understood(&pages::with_tip(error), json),
    };
    if let Some(voice) = cli.command.voice() {
        logs::start(voice);
    }
    if let Err(error) = signals::survive_file_limit() {
        tracing::debug!("a file over the limit of the shell ends the process: {error}");
    }
    let overridden = cli.command.scene().map_or(Ok(()), SceneArgs::take_set_file);
    let ready = overridden.and_then(|()| files::enough(&cli.command));
    match ready.and_then(|()| obey(&cli.command)) {
        Ok(exit) => exit.into(),
        Err(trouble) => {
            logs::error(&trouble);
            trouble.exit.into()
        }
    }
}

/// Help and the version are asked for the same way.
fn not_understood(error: &clap::Error, json: bool) -> ExitCode {
    let asked = !error.use_stderr();
    if !asked && logs::asked() {
        logs::start(&Voice { quiet: false, verbose: 0, log: Log::Json });
    }
    if asked {
        let done = match error.kind() {
            ErrorKind::DisplayVersion => exit::print(cullet::describe_version() + "\n"),
            _ => exit::unprinted(error.print().and_then(|()| std::io::stdout().flush())),
        };
        return match done {
            Ok(()) => ExitCode::SUCCESS,
            Err(trouble) => {
                logs::error(&trouble);
                trouble.exit.into()
            }
        };
    }
    let text = error.render().to_string();
    if json || logs::asked() || shown::output(&text) != text {
        let text = text.trim_end().trim_start_matches("error: ");
        logs::error(&exit::CommandError::new(exit::Exit::Usage, text));
    } else {
        // As clap has it, in colours.
        let _nobody_hears_it = error.print();
    }
    exit::Exit::Usage.into()
}

fn obey(command: &Command) -> Result<exit::Exit, exit::CommandError> {
    if command.is_client() {
        signals::end_when_told()?;
    }
    match command {
        Command::Run(args) if sweep::is_one(&args.scene.scene) => sweep::run(args),
        Command::Run(args) => run::run(args),
        Command::Coordinator(args) => serve::coordinator(args),
        Command::Worker(args) => serve::worker(args),
        Command::Router(args) => serve::router(args),
        Command::Job(args) => job::job(args),
        Command::Submit(args) if sweep::is_one(&args.scene.scene) => sweep::submit(args),
        Command::Submit(args) => client::submit(args),
        Command::Ps(args) => client::ps(args),
        Command::Show(args) => client::show(args),
        Command::Logs(args) => client::logs(args),
        Command::Watch(args) => client::watch(args),
        Command::Wait(args) => client::wait(args),
        Command::Cancel(args) => client::control(args, Client::cancel, Some("cancelled")),
        Command::Pause(args) => client::control(args, Client::pause, Some("paused")),
        Command::Resume(args) => client::control(args, Client::resume, None),
        Command::Retry(args) => client::control(args, Client::retry, None),
        Command::Delete(args) => client::delete(args),
        Command::Fetch(args) => match &args.what {
            What::Run(run) => client::fetch(args, *run),
            What::Sweep(file) => sweep::fetch(args, file),
        },
        Command::Workers(args) => workers::workers(args),
        Command::Drain(args) => workers::drain(args),
        Command::Doctor(args) => doctor::doctor(args),
        Command::Inspect(args) => inspect::inspect(args),
        Command::Recover(args) => inspect::recover(args),
        Command::Preview(args) => inspect::preview(args),
        Command::Still(args) => inspect::still(args),
        Command::Export(args) => export::run(args),
        Command::Report(args) => report::report(args),
        Command::Check(args) if sweep::is_one(&args.scene.scene) => sweep::check(&args.scene),
        Command::Check(args) => run::check(args),
        Command::OpenJob(args) => openjd::template(args),
        Command::Materials(args) => inspect::materials(args),
        Command::Schema(args) => inspect::schema(args),
        Command::New(args) => new::new(args),
        Command::Scenes(args) => shipped::list_scenes(args),
        Command::Completions(args) => pages::completions(args),
        Command::Man(args) => pages::man(args),
        Command::Bench(args) => bench::bench(args),
        Command::Frontier(args) => frontier::frontier(args),
    }
}
