//! `cullet openjd`: a scene or a sweep as an Open Job Description template, which Deadline Cloud,
//! `openjd` and other schedulers run. It is written as JSON, which they read as they read YAML, to
//! the schema `jobtemplate-2023-09` of
//! <https://github.com/OpenJobDescription/openjd-specifications>.

use crate::args::{OpenJobArgs, SceneArgs};
use crate::exit::{CommandError, Exit, print};
use crate::logs;
use crate::run::read_scene;
use crate::shown::shown;
use crate::sweep;
use cullet_files::output::write_file;
use serde_json::{Value, json};
use std::path::{Component, Path, PathBuf};

/// The schema of the template.
const VERSION: &str = "jobtemplate-2023-09";
/// Most characters of a job's name, and of the value of a parameter, in that schema.
const MAX_NAME: usize = 128;
const MAX_VALUE: usize = 1024;

/// What the template is about.
struct BatchJob {
    name: String,
    /// Runs of a sweep; `None`: one scene.
    runs: Option<usize>,
    /// What else must be there where it runs: the scene of a sweep, or the folder of a scene file.
    files: PathBuf,
}

/// Writes the template; all scenes in it are checked first.
pub(crate) fn template(args: &OpenJobArgs) -> Result<Exit, CommandError> {
    let job = job(args)?;
    let path = &args.scene.scene;
    let folder = match &args.output {
        Some(file) if file.extension().is_none_or(|end| end != "json") => {
            let text = format!("{}: a template is written as JSON; name it .json", file.display());
            return Err(CommandError::new(Exit::Usage, text).at(file.display()));
        }
        Some(file) => file.parent().unwrap_or(Path::new("")),
        None => Path::new(""),
    };
    if let Some(set) = args.scene.set.iter().find(|set| set.contains(['\n', '\r'])) {
        let text = format!("--set {}: an override in a template is a single line", shown(set));
        return Err(CommandError::new(Exit::Usage, text));
    }
    let overrides = args.scene.set.join("\n");
    if overrides.chars().count() > MAX_VALUE {
        let text = format!(
            "the overrides have {} characters; in a template they have at most {MAX_VALUE}",
            overrides.chars().count()
        );
        return Err(CommandError::new(Exit::Usage, text));
    }
    let mut parameters = vec![source(args, &job, folder)];
    parameters.extend(inputs(path, &job, folder));
    parameters.extend(shared(&job, &overrides));
    let template = json!({
        "specificationVersion": VERSION,
        "name": job.name,
        "description": about(path, &job),
        "parameterDefinitions": parameters,
        "steps": steps(&job, &args.sheet.at),
    });
    let text = format!("{template:#}\n");
    match &args.output {
        None => print(text)?,
        Some(file) => {
            let failed = |error| CommandError::file(file, error);
            write_file(file, text.as_bytes()).map_err(failed)?;
            logs::say(file.display());
        }
    }
    Ok(Exit::Done)
}

/// Reads what the template is of.
fn job(args: &OpenJobArgs) -> Result<BatchJob, CommandError> {
    let SceneArgs { scene: path, .. } = &args.scene;
    if sweep::is_one(path) {
        let (name, count, scene) = sweep::measure(&args.scene)?;
        args.sheet.fits(Some(count))?;
        let files = folder_of(&scene);
        return Ok(BatchJob { name: literal(&name), runs: Some(count), files });
    }
    args.sheet.fits(None)?;
    let scene = read_scene(&args.scene)?;
    let files = folder_of(path);
    Ok(BatchJob { name: literal(&scene.name), runs: None, files })
}

/// The folder of a scene, which has its other files.
fn folder_of(scene: &Path) -> PathBuf {
    let folder = if scene.is_dir() { scene } else { scene.parent().unwrap_or(scene) };
    folder.to_owned()
}

/// Text without what the schema reads as a reference or forbids in a name.
fn literal(text: &str) -> String {
    let plain: String = text.chars().filter(|c| !c.is_control()).take(MAX_NAME).collect();
    plain.replace("{{", "(").replace("}}", ")")
}

fn about(path: &Path, job: &BatchJob) -> String {
    let path = path.display().to_string();
    match job.runs {
        Some(count) => format!("Cullet: the {count} runs of the sweep {}", literal(&path)),
        None => format!("Cullet: a run of the scene {}", literal(&path)),
    }
}

/// The name of the parameter for what is run.
fn source_name(job: &BatchJob) -> &'static str {
    if job.runs.is_some() { "Sweep" } else { "Scene" }
}

/// The parameter for what is run.
fn source(args: &OpenJobArgs, job: &BatchJob, folder: &Path) -> Value {
    let path = &args.scene.scene;
    let name = source_name(job);
    let kind = if path.is_dir() { "DIRECTORY" } else { "FILE" };
    let mut parameter = json!({
        "name": name,
        "type": "PATH",
        "objectType": kind,
        "dataFlow": "IN",
        "description": "What is run: a scene or a sweep.",
    });
    match below(folder, path) {
        Some(default) => parameter["default"] = default.into(),
        None => logs::say(format!(
            "{name} has no default, for {} is not in the folder of the template: give it with the \
             job",
            path.display()
        )),
    }
    parameter
}

/// The parameter for the folder that schedulers take along with a file: no command names it.
fn inputs(path: &Path, job: &BatchJob, folder: &Path) -> Option<Value> {
    if !path.is_file() {
        return None;
    }
    let Some(default) = below(folder, &job.files) else {
        logs::say(format!(
            "there is no Inputs, for {} is not in the folder of the template: a scheduler that \
             takes files along takes none of it",
            job.files.display()
        ));
        return None;
    };
    Some(json!({
        "name": "Inputs",
        "type": "PATH",
        "objectType": "DIRECTORY",
        "dataFlow": "IN",
        "default": default,
        "description": "The folder with the meshes and other files that the scene names.",
    }))
}

/// The parameters that a scene and a sweep share.
fn shared(job: &BatchJob, overrides: &str) -> Vec<Value> {
    let output = json!({
        "name": "Output",
        "type": "PATH",
        "objectType": "DIRECTORY",
        "dataFlow": "OUT",
        "default": format!("runs/{}", file_name(&job.name)),
        "description": "The folder for the results; what an earlier try left there is replaced.",
    });
    let workers = json!({
        "name": "Workers",
        "type": "INT",
        "default": 2,
        "minValue": 1,
        "maxValue": 256,
        "description": "Worker processes of a run; they change no result.",
    });
    let set = json!({
        "name": "Overrides",
        "type": "STRING",
        "default": overrides,
        "description": "Values of the scene to override, a PATH=VALUE on each line.",
        "userInterface": { "control": "MULTILINE_EDIT" },
    });
    let program = json!({
        "name": "Cullet",
        "type": "STRING",
        "default": "cullet",
        "minLength": 1,
        "description": "The program: on the path, or where it is.",
    });
    vec![output, workers, set, program]
}

/// A name that is a folder's.
fn file_name(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_. ".contains(c) { c } else { '-' };
    name.chars().map(plain).collect()
}

/// One step for a scene; for a sweep one with a task per run, and one that gathers them.
fn steps(job: &BatchJob, times: &[f64]) -> Value {
    let workers = ["--replace", "--workers", "{{Param.Workers}}"];
    let Some(count) = job.runs else {
        return json!([{ "name": "Run", "script": script(job, &workers) }]);
    };
    let only = [&["--only", "{{Task.Param.Run}}"][..], &workers].concat();
    let times = times.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let at = ["--at", &times];
    let gather = [&["--gather"][..], if times.is_empty() { &[] } else { &at }].concat();
    json!([
        {
            "name": "Runs",
            "parameterSpace": {
                "taskParameterDefinitions": [
                    { "name": "Run", "type": "INT", "range": format!("1-{count}") },
                ],
            },
            "script": script(job, &only),
        },
        {
            "name": "Gather",
            "dependencies": [{ "dependsOn": "Runs" }],
            "script": script(job, &gather),
        },
    ])
}

/// A call of `cullet run` with the parameters that all calls have, and more.
fn script(job: &BatchJob, more: &[&str]) -> Value {
    let source = format!("{{{{Param.{}}}}}", source_name(job));
    let set = ["--set-file", "{{Task.File.Overrides}}"];
    let args = [&["run", &source, "--out", "{{Param.Output}}"][..], &set, more].concat();
    json!({
        "embeddedFiles": [{
            "name": "Overrides",
            "type": "TEXT",
            "filename": "overrides.txt",
            "data": "{{Param.Overrides}}\n",
        }],
        "actions": { "onRun": { "command": "{{Param.Cullet}}", "args": args } },
    })
}

/// A path relative to the folder of the template, if it is in it: schedulers take no other default.
fn below(folder: &Path, path: &Path) -> Option<String> {
    let whole = |path: &Path| Path::new(".").join(path).canonicalize().ok();
    let (base, path) = (whole(folder)?, whole(path)?);
    let inside = path.strip_prefix(&base).ok()?;
    let parts: Option<Vec<&str>> = inside
        .components()
        .map(|part| match part {
            Component::Normal(name) => name.to_str(),
            _ => None,
        })
        .collect();
    let parts = parts?;
    Some(if parts.is_empty() { ".".to_owned() } else { parts.join("/") })
}

#[cfg(test)]
mod tests {
    use super::{BatchJob, below, literal, script, steps};
    use std::fs;
    use std::path::{Path, PathBuf};

    fn job(runs: Option<usize>) -> BatchJob {
        BatchJob { name: "seeds".to_owned(), runs, files: PathBuf::new() }
    }

    #[test]
    fn a_scene_has_one_step_and_a_sweep_a_task_per_run_and_one_that_waits_for_them() {
        let one = steps(&job(None), &[]);
        assert_eq!(one.as_array().map(Vec::len), Some(1));
        let both = steps(&job(Some(6)), &[0.1, 0.25]);
        let space = &both[0]["parameterSpace"]["taskParameterDefinitions"][0];
        assert_eq!((&space["name"], &space["range"]), (&"Run".into(), &"1-6".into()));
        assert_eq!(both[1]["dependencies"][0]["dependsOn"], both[0]["name"]);
        let args = |step: usize| both[step]["script"]["actions"]["onRun"]["args"].to_string();
        assert!(args(0).contains(r#""--only","{{Task.Param.Run}}""#), "{}", args(0));
        assert!(args(1).ends_with(r#""--gather","--at","0.1,0.25"]"#), "{}", args(1));
        assert!(!args(1).contains("--only") && !args(1).contains("--workers"), "{}", args(1));
    }

    #[test]
    fn each_call_has_its_overrides_in_a_file() {
        let scene = script(&job(None), &[]);
        assert_eq!(scene["embeddedFiles"][0]["data"], "{{Param.Overrides}}\n");
        let args = scene["actions"]["onRun"]["args"].to_string();
        assert!(args.starts_with(r#"["run","{{Param.Scene}}","--out","{{Param.Output}}""#));
        assert!(args.contains(r#""--set-file","{{Task.File.Overrides}}""#), "{args}");
    }

    #[test]
    fn defaults_are_paths_in_the_folder_of_the_template() {
        let folder = tempfile::tempdir().expect("a folder");
        let (inner, other) = (folder.path().join("a/b"), folder.path().join("c"));
        fs::create_dir_all(&inner).expect("a folder");
        fs::create_dir_all(&other).expect("a folder");
        assert_eq!(below(folder.path(), &inner).as_deref(), Some("a/b"));
        assert_eq!(below(&inner, &inner).as_deref(), Some("."));
        assert_eq!(below(&other, &inner), None);
        assert_eq!(below(folder.path(), &folder.path().join("none")), None);
        assert_eq!(below(Path::new(""), Path::new("src")).as_deref(), Some("src"), "from here");
        assert_eq!(below(Path::new("."), Path::new("")).as_deref(), Some("."));
    }

    #[test]
    fn names_refer_to_nothing() {
        assert_eq!(literal("a {{Param.X}}\n"), "a (Param.X)");
        assert_eq!(literal(&"é".repeat(200)).chars().count(), 128);
    }
}
