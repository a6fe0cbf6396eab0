//! What is made of the list of commands: completions, manual pages, advice on arguments.

use crate::args::{self, Cli};
use crate::exit::{CommandError, Exit, print};
use crate::folder::Folder;
use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Arguments that people look for and that are values of a scene.
const OF_SCENES: [(&str, &str, &str); 8] = [
    ("--seed", "world.seed", "3"),
    ("--duration", "world.duration", "2"),
    ("--step", "world.step", "1/480"),
    ("--gravity", "world.gravity", "[0,0,-9.81]"),
    ("--particles", "fracture.max_particles", "40000"),
    ("--max-particles", "fracture.max_particles", "40000"),
    ("--solver", "fracture.solver", "brittle"),
    ("--error", "fidelity.error", "0.3"),
];

pub(crate) fn completions(args: &args::Completions) -> Result<Exit, CommandError> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "cullet", &mut text);
    print(String::from_utf8_lossy(&text))?;
    Ok(Exit::Done)
}

pub(crate) fn man(args: &args::Man) -> Result<Exit, CommandError> {
    let folder = Folder::at(&args.folder)?;
    let written = clap_mangen::generate_to(Cli::command(), &folder.path);
    written.map_err(|error| CommandError::file(&args.folder, error))?;
    Ok(Exit::Done)
}

/// An argument that is none, but the name of a value of scenes, is reported with how that is set.
pub(crate) fn with_tip(mut error: clap::Error) -> clap::Error {
    let argument = match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::UnknownArgument, Some(ContextValue::String(argument))) => argument.clone(),
        _ => return error,
    };
    let name = argument.split('=').next().unwrap_or_default();
    let Some((_, key, example)) = OF_SCENES.iter().find(|(known, ..)| *known == name) else {
        return error;
    };
    let value = given(name).unwrap_or_else(|| (*example).to_owned());
    let tip = format!("a value of a scene is set with --set {key}={value}");
    error.remove(ContextKind::SuggestedArg);
    error.remove(ContextKind::TrailingArg);
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    error
}

/// The value that was typed with an argument, after it or after an equals sign.
fn given(name: &str) -> Option<String> {
    let mut typed = std::env::args_os().map(|text| text.to_string_lossy().into_owned());
    let found = typed.find(|text| text.split('=').next() == Some(name))?;
    let value = match found.split_once('=') {
        Some((_, value)) => value.to_owned(),
        None => typed.next()?,
    };
    (!value.is_empty() && !value.starts_with('-')).then_some(value)
}
