//! Numbers that took long to compute, on disk.

use std::fs;
use std::path::{Path, PathBuf};

/// A folder of numbers, each file under a key: all that the numbers depend on, in words.
#[derive(Clone, Debug)]
pub struct Cache(PathBuf);

impl Cache {
    /// In this folder, which is made if it is not there.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn new(folder: &Path) -> Result<Self, String> {
        fs::create_dir_all(folder).map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
        Ok(Self(folder.into()))
    }

    /// The numbers of this key, if they are there: a file that is cut short or belongs to another key is not.
    pub fn load(&self, key: &str) -> Option<Vec<f64>> {
        let bytes = fs::read(self.path(key)).ok()?;
        let numbers = bytes.strip_prefix(header(key).as_bytes())?;
        let (count, numbers) = numbers.split_first_chunk::<8>()?;
        let (numbers, rest) = numbers.as_chunks::<8>();
        let whole = rest.is_empty() && u64::from_le_bytes(*count) == numbers.len() as u64;
        whole.then(|| numbers.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect())
    }

    /// Keeps numbers under a key.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn store(&self, key: &str, numbers: &[f64]) -> Result<(), String> {
        let mut bytes = header(key).into_bytes();
        bytes.extend((numbers.len() as u64).to_le_bytes());
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        let path = self.path(key);
        fs::write(&path, bytes).map_err(|error| format!("cannot write {}: {error}", path.display()))
    }

    fn path(&self, key: &str) -> PathBuf {
        self.0.join(format!("{:016x}.bin", fnv1a(key)))
    }
}

fn header(key: &str) -> String {
    format!("{key}\n")
}

/// FNV-1a: the same on every machine and in every version of the compiler.
fn fnv1a(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_its_definition() {
        assert_eq!(fnv1a(""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a("foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn numbers_come_back_under_their_key_alone() {
        let folder = std::env::temp_dir().join(format!("lab-cache-{}", std::process::id()));
        let cache = Cache::new(&folder).unwrap();
        let numbers = [1.5, -0.0, f64::MAX, 1e-300];
        cache.store("one", &numbers).unwrap();
        assert_eq!(cache.load("one").as_deref(), Some(&numbers[..]));
        assert_eq!(cache.load("two"), None);
        let path = cache.path("one");
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() - 8]).unwrap();
        assert_eq!(cache.load("one"), None);
        fs::copy(&path, cache.path("two")).unwrap();
        assert_eq!(cache.load("two"), None);
        fs::remove_dir_all(folder).unwrap();
    }
}
