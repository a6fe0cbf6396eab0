//! `cullet run` and `cullet check`.

use crate::advice::require_scene;
use crate::exit::{CommandError, Exit, print, refused};
use crate::folder::{Folder, clear_run, to_replace_run};
use crate::live::LivePage;
use crate::progress::ProgressDisplay;
use crate::shown::{lines as lines_of, shown};
use crate::signals::stop_when_told;
use crate::viewers::LiveViewers;
use crate::{args, logs};
use cullet::{LocalPool, LocalRunError, LocalWorkers, Scene, spare_cores};
use cullet::{Outcome, Recording, RunError, RunOptions};
use cullet_picture::Framing;
use cullet_proto::service::causes::NOT_FINITE;
use std::path::Path;
use std::sync::atomic::AtomicBool;

pub(crate) fn run(args: &args::RunArgs) -> Result<Exit, CommandError> {
    if args.part.only.is_some() || args.part.gather {
        let path = args.scene.scene.display();
        let text = format!("{path}: --only and --gather are for sweeps, and it is a scene");
        return Err(CommandError::new(Exit::Usage, text).at(path));
    }
    args.sheet.fits(None)?;
    let scene = read_scene(&args.scene)?;
    run_scene(&scene, args, (&args.scene.set, args.out.as_deref()))
}

/// Runs one scene that was read with `set`, into the folder `out`.
pub(crate) fn run_scene(
    scene: &Scene,
    args: &args::RunArgs,
    (set, out): (&[String], Option<&Path>),
) -> Result<Exit, CommandError> {
    let framing = checked_framing(args.close.framing(), scene)?;
    let again = if args.part.only.is_some() { args.again.of_sweep() } else { args.again.options() };
    // Before anything is deleted or made.
    again.check(out, std::slice::from_ref(scene)).map_err(|error| trouble(&error))?;
    let stop = stop_when_told("the recording is finished first")?;
    let folder = match out.filter(|_| args.replace) {
        Some(out) => to_replace_run(out)?,
        None => Folder::of(out, &scene.name)?,
    };
    let out = &folder.path;
    let named = std::iter::once((scene.name.clone(), set.to_vec()));
    let mut live =
        LivePage::open(args.live, named, args.voice.quiet).inspect_err(|_| folder.forget())?;
    let viewers = LiveViewers::open(args.foxglove, args.voice.quiet);
    let viewers = viewers.inspect_err(|_| folder.forget())?;
    let pool = start_pool(args).inspect_err(|_| folder.forget())?;
    if args.replace {
        clear_run(out)?;
    }
    let mut progress = ProgressDisplay::new(args.voice.quiet);
    let tap = viewers.as_ref().map(|viewers| viewers.begin(&scene.name));
    let options = RunOptions { out, stop: &stop, tap, again };
    live.iter_mut().for_each(|page| page.begin(0, out, &pool));
    let outcome = pool.run(scene, &options, &mut |news| {
        progress.show(news);
        live.iter_mut().for_each(|page| page.show(news, &pool));
    });
    progress.done();
    viewers.iter().for_each(LiveViewers::end);
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => {
            folder.forget();
            let trouble = trouble(&error);
            // Said before the page stays for a while.
            logs::error(&trouble);
            end_page(live.as_mut(), (trouble.exit, &trouble.to_string()), &pool, (&stop, args));
            return Ok(trouble.exit);
        }
    };
    // A run without its pictures is still a run.
    let drawn = match args.no_pictures {
        true => Ok(()),
        false => draw(&outcome.recording, out, &framing),
    };
    if let Err(trouble) = &drawn {
        logs::warn(trouble);
    }
    report(&outcome, out, args.json, args.voice.quiet)?;
    let exit = exit_of(&outcome, drawn.is_ok());
    end_page(live.as_mut(), (exit, &outcome.unmet.join("; ")), &pool, (&stop, args));
    Ok(exit)
}

/// What pictures of a scene show, if it has the body that they are to show.
pub(crate) fn checked_framing(framing: Framing, scene: &Scene) -> Result<Framing, CommandError> {
    let Framing::Body(wanted) = &framing else { return Ok(framing) };
    let rigid = scene.bodies.iter().map(|body| &body.name[..]);
    let names: Vec<&str> = rigid.chain(scene.moving.iter().map(|body| &body.name[..])).collect();
    if names.contains(&&wanted[..]) {
        return Ok(framing);
    }
    let text = format!("--close={wanted}: the scene has no such body; it has {}", names.join(", "));
    Err(CommandError::new(Exit::Usage, text))
}

/// Shows how the run ended, for a while.
fn end_page(
    page: Option<&mut LivePage>,
    (exit, why): (Exit, &str),
    pool: &LocalPool,
    (stop, args): (&AtomicBool, &args::RunArgs),
) {
    if let Some(page) = page {
        page.end(exit, why, pool);
        page.linger(pool, stop, args.voice.quiet);
    }
}

pub(crate) fn check(args: &args::Check) -> Result<Exit, CommandError> {
    let scene = read_scene(&args.scene)?;
    let (bodies, steps, step) = (scene.bodies.len(), scene.steps(), scene.world.step);
    let moving = match scene.moving.len() {
        0 => String::new(),
        count => format!("{count} that move as they deform, "),
    };
    let mut lines = vec![
        format!("{}: {}", shown(&scene.name), lines_of(&scene.description)),
        format!("{bodies} bodies, {moving}{steps} steps of {step} s"),
    ];
    for body in &scene.bodies {
        let triangles = body.solid.mesh.triangles.len();
        let mass = body.volume * body.material.density;
        let (name, material) = (shown(&body.name), shown(&body.material.name));
        lines.push(format!("  {name}: {material}, {mass:.4} kg, {triangles} triangles"));
        lines.extend(body.repairs.iter().map(|line| format!("    {}", shown(line))));
    }
    for body in &scene.moving {
        let (name, material, about) = (shown(&body.name), shown(&body.material.name), body.about());
        lines.push(format!("  {name}: {material}, {about}"));
    }
    for hit in &scene.directions.hits {
        let (body, from) = (shown(&hit.body), hit.at);
        lines.push(format!("  directed: the first hit of {body} from {from} s on: {hit}"));
    }
    lines.extend(scene.warnings.iter().map(|line| format!("warning: {}", lines_of(line))));
    print(lines.join("\n") + "\n")?;
    Ok(Exit::Done)
}

/// Reads a scene, or says everything that is wrong with it.
pub(crate) fn read_scene(args: &args::SceneArgs) -> Result<Scene, CommandError> {
    require_scene(&args.scene)?;
    let wrong = |errors| CommandError::new(Exit::Usage, errors).at(args.scene.display());
    Scene::load(&args.scene, &args.set).map_err(wrong)
}

pub(crate) fn start_pool(args: &args::RunArgs) -> Result<LocalPool, CommandError> {
    let workers = args.workers.map_or_else(spare_cores, usize::from);
    let exe = std::env::current_exe().map_err(|error| CommandError::new(Exit::Broken, error))?;
    let mut processes = LocalWorkers::processes(exe, workers, usize::from(args.threads));
    if let LocalWorkers::Processes(spawn) = &mut processes {
        spawn.args.extend(args.voice.words());
        spawn.args.extend(args.memory.words(workers));
    }
    LocalPool::start(&processes).map_err(|error| match error {
        LocalRunError::Pool(error) => refused(&error),
        other => CommandError::new(Exit::Broken, other),
    })
}

pub(crate) fn trouble(error: &RunError) -> CommandError {
    let exit = match error {
        error if error.is_refusal() => Exit::Usage,
        RunError::Record(_) | RunError::File { .. } => Exit::Unkept,
        RunError::Abandoned { .. } => Exit::Stalled,
        _ => Exit::Failed,
    };
    let trouble = CommandError::new(exit, error);
    if error.is_not_finite() { trouble.by(NOT_FINITE) } else { trouble }
}

/// Draws the pictures of a recording into a folder.
pub(crate) fn draw(recording: &Path, out: &Path, framing: &Framing) -> Result<(), CommandError> {
    let failed = |error| CommandError::new(Exit::File, format!("the run has no picture: {error}"));
    let read = Recording::open(recording).map_err(failed)?;
    cullet_picture::framed(&read, out, framing).map(|_| ()).map_err(failed)
}

/// How a run ended; `pictured`: whether its pictures were drawn.
pub(crate) fn exit_of(outcome: &Outcome, pictured: bool) -> Exit {
    match (outcome.interrupted, outcome.unmet.is_empty(), pictured) {
        (true, _, _) => Exit::Interrupted,
        (false, false, _) => Exit::Unmet,
        (false, true, false) => Exit::Unpictured,
        (false, true, true) => Exit::Done,
    }
}

fn report(outcome: &Outcome, out: &Path, json: bool, quiet: bool) -> Result<(), CommandError> {
    if json {
        print(outcome.summary.to_json())?;
    }
    for text in &outcome.unmet {
        logs::warn(format!("expected, and does not hold: {}", lines_of(text)));
    }
    if !quiet {
        let s = &outcome.summary;
        let shares = s.shares.as_ref().filter(|_| s.fractures > 0);
        let shares = shares.map(|shares| format!(" (sampled: {})", shares.tell_sampled()));
        logs::say(format!(
            "{}: {} fractures, {} fragments{}, {} bodies left after {:.3} s in {:.1} s; {}",
            shown(&s.scene),
            s.fractures,
            s.fragments,
            shares.unwrap_or_default(),
            s.bodies_final,
            s.sim_seconds,
            s.wall_seconds,
            out.display()
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_geometry::Vec3;
    use cullet_world::WorldError;

    #[test]
    fn a_body_that_does_not_follow_its_velocity_ends_a_run_with_code_2() {
        let velocity = Vec3::new(0.0, 0.0, -9.0);
        let (name, step, moved, due) = ("left.0.0".to_owned(), 12, 0.018, 0.18);
        let frozen = WorldError::Frozen { name, step, velocity, moved, due };
        assert_eq!(trouble(&RunError::World(frozen)).exit.code(), 2);
    }
}
