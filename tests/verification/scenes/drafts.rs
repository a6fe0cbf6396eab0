//! What a draft of a scene predicts of the whole run.

use super::{Cullet, Path, Recording, Shown, unique};

impl Shown {
    /// The largest five pieces of a draft are within 15 % of the run's.
    pub(super) fn is_predicted_by_a_draft(&self, name: &str) {
        let folder = unique("draft");
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name);
        let draft = ["run", "-q", "--draft", "--no-pictures", "--out"];
        let run = Cullet::new(&draft).path(&folder).path(&scene).output();
        assert_eq!(run.code, 0, "{name}: {}", run.stderr);
        let recording = Recording::open(&folder.join("run.mcap")).expect("a recording");
        let points = |recording: &Recording| recording.sheet_frames[0].offsets.len();
        assert!(2 * points(&recording) < points(&self.recording()), "a draft has fewer points");
        let ranks = cullet_record::ranks(&recording, &self.recording(), 5);
        let apart = ranks.iter().all(|rank| rank.difference().abs() < 0.15);
        assert!(ranks.len() >= 2 && apart, "{}", cullet_record::rank_table(&ranks));
        let told = Cullet::new(&["inspect"]).path(&folder).args(&["--against"]).path(&self.folder);
        let told = told.output();
        assert!(told.code == 0 && told.stdout.contains("% apart"), "{}", told.stdout);
        std::fs::remove_dir_all(&folder).ok();
    }
}
