//! `cullet new` and `cullet scenes`: arguments and their help.

use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct New {
    /// The folder to create; it also names the scene
    #[arg(value_name = "NAME")]
    pub(crate) folder: PathBuf,
    /// Copy the shipped scene of this name, with all its files; `cullet scenes` lists them
    #[arg(long, value_name = "SCENE")]
    pub(crate) from: Option<String>,
    /// Copy this mesh (.obj, .stl, .ply, .glb or .gltf) and make a scene in which it falls onto a
    /// floor
    #[arg(long, value_name = "FILE", conflicts_with = "from")]
    pub(crate) mesh: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Scenes {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}
