//! What resolving a document needs, and what is wrong with it.

use super::format::Fidelity;
use super::geometry::GeometryCache;
use super::material::SceneMaterial;
use super::motions::MotionCache;
use cullet_document::error::{SceneError, SceneErrorKind, nearest};
use cullet_document::files::{FileError, Files};
use cullet_document::tree::{Node, Path, Step, below, show};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Errors that are told with the name that may have been meant.
const ADVISED: usize = 100;

/// What resolving needs and collects.
pub struct ResolveContext<'a> {
    /// The tree, for places.
    pub root: &'a Node,
    /// Where meshes come from.
    pub files: &'a mut Files,
    /// Solids made so far.
    pub geometries: GeometryCache,
    /// Motions read so far.
    pub(super) motions: MotionCache,
    /// Materials by name.
    pub(super) materials: BTreeMap<String, Arc<SceneMaterial>>,
    /// Names of materials that are wrong themselves: naming them is not a second error.
    pub(super) spoiled_materials: BTreeSet<String>,
    /// Numbers of the rigid bodies by name; sheets name them.
    pub(super) objects: BTreeMap<String, u32>,
    /// Where a sheet names a rigid body that was not made, and its name.
    pub(super) absent: Vec<(Path, String)>,
    /// What is wrong.
    pub errors: Vec<SceneError>,
    /// What is unusual, a line each.
    pub warnings: Vec<String>,
    /// Paths of values that are wrong by themselves, which was said already.
    pub(super) bad: BTreeSet<Path>,
    /// How coarse a draft is.
    pub(super) fidelity: Fidelity,
}

impl<'a> ResolveContext<'a> {
    /// With nothing made yet.
    pub fn new(root: &'a Node, files: &'a mut Files) -> Self {
        Self {
            root,
            files,
            geometries: GeometryCache::default(),
            motions: MotionCache::default(),
            materials: BTreeMap::new(),
            spoiled_materials: BTreeSet::new(),
            objects: BTreeMap::new(),
            absent: Vec::new(),
            errors: Vec::new(),
            warnings: Vec::new(),
            bad: BTreeSet::new(),
            fidelity: Fidelity::default(),
        }
    }
}

impl ResolveContext<'_> {
    /// Number of the rigid body that a path names. One that was not made is noted, and has none.
    pub(super) fn object(&mut self, name: &str, path: &[Step]) -> u32 {
        let known = self.objects.get(name).copied();
        known.unwrap_or_else(|| {
            self.absent.push((path.to_vec(), name.to_owned()));
            u32::MAX
        })
    }

    /// Whether an item has none of these keys, as far as can be told: where one of them is wrong,
    /// or one that is not known was meant for it, it is no second error that it is missing.
    pub(super) fn lacks(&self, path: &[Step], keys: &[&str]) -> bool {
        let meant = |bad: &Path| match bad.strip_prefix(path) {
            Some([Step::Key(key), ..]) => nearest(key, keys.iter().copied()).is_some(),
            Some(_) => true,
            None => false,
        };
        !below(&self.bad, path).any(meant)
    }

    /// Whether what is wrong at a path is the consequence of an error that was noted.
    fn is_told(&self, path: &[Step]) -> bool {
        self.lies_in_bad(path) || path.len() > 2 && below(&self.bad, path).next().is_some()
    }

    /// What `look` finds among all names of a scene as meant by one that is not known. That has its
    /// price: the first errors have it, which are those that are shown.
    pub(super) fn advice<T>(&self, look: impl FnOnce() -> Option<T>) -> Option<T> {
        if self.errors.len() < ADVISED { look() } else { None }
    }

    /// Notes an error at a path.
    pub fn wrong(&mut self, path: &[Step], message: impl Into<String>) {
        self.wrong_with(path, message, None);
    }

    /// Notes an error at a path, with advice.
    pub fn wrong_with(&mut self, path: &[Step], message: impl Into<String>, help: Option<String>) {
        if self.is_told(path) {
            return;
        }
        let error = SceneError::at(self.root.nearest(path), show(path), message);
        self.errors.push(error.help(help));
    }

    /// Notes that no body can be made of what was read, or that there is no room for it.
    pub(super) fn unmade(
        &mut self,
        path: &[Step],
        message: impl Into<String>,
        help: Option<String>,
    ) {
        let error = SceneError::at(self.root.nearest(path), show(path), message).help(help);
        self.errors.push(error.of_kind(SceneErrorKind::Geometry));
    }

    /// Whether a mesh file is there, and of a format that is read; what is wrong is noted.
    pub fn has_mesh(&mut self, key: &str, path: &[Step]) -> bool {
        if let Err(why) = cullet_assets::known(key) {
            self.wrong(path, why.to_string());
            return false;
        }
        self.has_file(key, path)
    }

    /// Whether a file is there; what is wrong is noted.
    pub(super) fn has_file(&mut self, key: &str, path: &[Step]) -> bool {
        let Err(why) = self.files.get(key) else { return true };
        let from = match key.split_once('/') {
            Some((_, absolute)) if absolute.starts_with('/') => None,
            Some(("given", _)) => Some("a path in --set is taken from the current folder"),
            _ => Some("a path in a file is taken from the folder of that file"),
        };
        let there = matches!(why, FileError::Unreadable { .. });
        self.wrong_with(path, why.to_string(), from.filter(|_| there).map(str::to_owned));
        false
    }
}
