//! A sweep as its file says, and its scenes.

use crate::args::SceneArgs;
use crate::exit::{CommandError, Exit};
use crate::run::read_scene;
use cullet::Scene;
use cullet_coordinator::sweep::{Sweep, is_sweep};
use cullet_files::regular;
use cullet_proto::service::MAX_TICKET;
use std::path::{Path, PathBuf};

/// A sweep, and what its file is called.
pub(super) struct Named {
    pub(super) name: String,
    pub(super) sweep: Sweep,
    /// Where its scene is.
    pub(super) scene: PathBuf,
}

pub(super) fn read(file: &Path) -> Result<Named, CommandError> {
    let text = regular::read_text(file).map_err(|error| CommandError::file(file, error))?;
    let wrong = |text: String| {
        CommandError::new(Exit::Usage, format!("{}: {text}", file.display())).at(file.display())
    };
    if !is_sweep(&text) {
        return Err(wrong("it is no sweep: it has neither [product] nor [[zip]]".to_owned()));
    }
    let sweep = Sweep::read(&text).map_err(|error| wrong(error.to_string()))?;
    let name = file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let mut name = name.unwrap_or_default();
    name.truncate(name.floor_char_boundary(MAX_TICKET));
    let scene = file.parent().unwrap_or(Path::new("")).join(&sweep.scene);
    Ok(Named { name, sweep, scene })
}

/// A sweep with all its scenes, each checked.
pub(super) struct PreparedSweep {
    pub(super) named: Named,
    pub(super) scenes: Vec<Scene>,
}

pub(super) fn plan(args: &SceneArgs) -> Result<PreparedSweep, CommandError> {
    let named = read(&args.scene)?;
    let mut scenes = Vec::new();
    for index in 0..named.sweep.rows.len() {
        scenes.push(named.scene(index, &args.set)?);
    }
    Ok(PreparedSweep { named, scenes })
}

impl Named {
    /// The scene of a row, with what is set for all.
    pub(super) fn scene(&self, index: usize, more: &[String]) -> Result<Scene, CommandError> {
        let row = &self.sweep.rows[index];
        let set = [&self.sweep.overrides(row)[..], more].concat();
        let args = SceneArgs { scene: self.scene.clone(), set, set_file: None, draft: None };
        read_scene(&args).map_err(|trouble| {
            let text = format!("{}: {trouble}", self.sweep.label(row));
            trouble.said(text)
        })
    }

    /// What is set for each run, with what is set for all.
    pub(super) fn sets(&self, more: &[String]) -> Vec<Vec<String>> {
        let set = |row: &Vec<String>| [&self.sweep.overrides(row)[..], more].concat();
        self.sweep.rows.iter().map(set).collect()
    }
}
