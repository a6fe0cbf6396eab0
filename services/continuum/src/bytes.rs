//! The bytes of a state: little-endian numbers, one after the other.

use cullet_model::Refusal;

/// Writes a state.
#[derive(Clone, Debug, Default)]
pub struct StateWriter(pub Vec<u8>);

impl StateWriter {
    /// Puts a number of eight bytes.
    pub fn number(&mut self, value: u64) {
        self.0.extend(value.to_le_bytes());
    }

    /// Puts a number of four bytes.
    pub fn short(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    /// Puts a real number, bit by bit.
    pub fn real(&mut self, value: f64) {
        self.number(value.to_bits());
    }
}

/// Reads a state off the front of its bytes.
#[derive(Clone, Copy, Debug)]
pub struct StateReader<'a> {
    family: &'static str,
    rest: &'a [u8],
}

impl<'a> StateReader<'a> {
    /// Starts at the front of the bytes of a state of this family.
    #[must_use]
    pub fn new(family: &'static str, bytes: &'a [u8]) -> Self {
        Self { family, rest: bytes }
    }

    /// That the state is none of the body's.
    #[must_use]
    pub fn foreign(&self, why: &str) -> Refusal {
        let lack = format!("the state is none of this body: {why}");
        Refusal::Unfit { solver: self.family, lack }
    }

    /// The next `count` bytes.
    ///
    /// # Errors
    ///
    /// If there are fewer.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Refusal> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return Err(self.foreign("it is cut short"));
        };
        self.rest = rest;
        Ok(taken)
    }

    /// The next number of eight bytes.
    ///
    /// # Errors
    ///
    /// If it is cut short.
    pub fn number(&mut self) -> Result<u64, Refusal> {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(self.take(8)?);
        Ok(u64::from_le_bytes(bytes))
    }

    /// The next number of four bytes.
    ///
    /// # Errors
    ///
    /// If it is cut short.
    pub fn short(&mut self) -> Result<u32, Refusal> {
        let mut bytes = [0; 4];
        bytes.copy_from_slice(self.take(4)?);
        Ok(u32::from_le_bytes(bytes))
    }

    /// The next real number.
    ///
    /// # Errors
    ///
    /// If it is cut short.
    pub fn real(&mut self) -> Result<f64, Refusal> {
        Ok(f64::from_bits(self.number()?))
    }

    /// That nothing follows.
    ///
    /// # Errors
    ///
    /// If something does.
    pub fn end(&self) -> Result<(), Refusal> {
        if self.rest.is_empty() { Ok(()) } else { Err(self.foreign("it goes on after its end")) }
    }
}

/// Memory of the elements of a list \[bytes\].
#[must_use]
pub fn held<T>(list: &[T]) -> u64 {
    size_of_val(list) as u64
}

/// The same of a list of lists, with theirs.
#[must_use]
pub fn held_lists<T>(lists: &[Vec<T>]) -> u64 {
    held(lists) + lists.iter().map(|list| held(list)).sum::<u64>()
}

#[cfg(test)]
mod tests {
    use super::{StateReader, StateWriter};

    #[test]
    fn what_is_written_is_read_and_what_is_cut_short_or_long_is_refused() {
        let mut bytes = StateWriter::default();
        bytes.number(7);
        bytes.short(3);
        bytes.real(-0.1);
        let mut reader = StateReader::new("family", &bytes.0);
        assert_eq!(reader.number().unwrap(), 7);
        assert!(reader.end().is_err());
        assert_eq!(reader.short().unwrap(), 3);
        assert_eq!(reader.real().unwrap().to_bits(), (-0.1_f64).to_bits());
        reader.end().unwrap();
        let why = reader.number().unwrap_err().to_string();
        assert!(why.contains("cut short"), "{why}");
    }
}
