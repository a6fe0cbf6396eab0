//! How much is logged, and in which form.

use super::Command;
use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct Voice {
    /// Log errors only
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Log more; if given twice, messages of the libraries too
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,
    /// Format of the log lines on standard error
    #[arg(long, value_enum, default_value_t = Log::Text)]
    pub(crate) log: Log,
}

/// The format of log lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Log {
    /// Text for people
    Text,
    /// One JSON object per line
    Json,
}

impl Voice {
    /// The arguments that make a process of ours log in the same way.
    pub(crate) fn words(&self) -> Vec<String> {
        let json = ["--log", "json"].iter().filter(|_| self.log == Log::Json);
        let quiet = ["--quiet"].iter().filter(|_| self.quiet);
        let verbose = std::iter::repeat_n(&"--verbose", usize::from(self.verbose));
        json.chain(quiet).chain(verbose).map(|&word| word.to_owned()).collect()
    }
}

impl Command {
    /// How it logs; a command without log lines prints only what it was asked for.
    pub(crate) fn voice(&self) -> Option<&Voice> {
        match self {
            Self::Run(args) => Some(&args.voice),
            Self::Coordinator(args) => Some(&args.voice),
            Self::Worker(args) => Some(&args.voice),
            Self::Router(args) => Some(&args.voice),
            Self::Submit(args) => Some(&args.place.who.voice),
            Self::Ps(args) | Self::Workers(args) => Some(&args.place.who.voice),
            Self::Delete(args) => Some(&args.place.who.voice),
            Self::Drain(args) => Some(&args.place.who.voice),
            Self::Fetch(args) => Some(&args.place.who.voice),
            Self::Doctor(args) => Some(&args.who.voice),
            Self::Show(args)
            | Self::Logs(args)
            | Self::Watch(args)
            | Self::Wait(args)
            | Self::Cancel(args)
            | Self::Pause(args)
            | Self::Resume(args)
            | Self::Retry(args) => Some(&args.place.who.voice),
            Self::Bench(args) => Some(&args.voice).filter(|voice| voice.log == Log::Json),
            Self::Frontier(args) => Some(&args.voice).filter(|voice| voice.log == Log::Json),
            Self::Inspect(_)
            | Self::Recover(_)
            | Self::Report(_)
            | Self::Preview(_)
            | Self::Still(_)
            | Self::Export(_)
            | Self::Check(_)
            | Self::OpenJob(_)
            | Self::Materials(_)
            | Self::Schema(_)
            | Self::New(_)
            | Self::Scenes(_)
            | Self::Completions(_)
            | Self::Man(_)
            | Self::Job(_) => None,
        }
    }
}
