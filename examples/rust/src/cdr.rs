//! ROS 2 messages as bytes: little-endian CDR, every field aligned to its own size after a header of 4 bytes.

/// Reads the fields of a message one after the other.
pub struct Reader<'a> {
    data: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub fn new(message: &'a [u8]) -> Result<Self, String> {
        let data = message.get(4..).ok_or("a message is shorter than its header")?;
        Ok(Reader { data, at: 0 })
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let begin = self.at.next_multiple_of(N);
        self.at = begin + N;
        let found = self.data.get(begin..self.at).ok_or("a message ends too early")?;
        Ok(found.try_into().unwrap())
    }

    pub fn u8(&mut self) -> Result<u8, String> {
        Ok(u8::from_le_bytes(self.bytes()?))
    }

    pub fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    pub fn u64(&mut self) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.bytes()?))
    }

    pub fn i64(&mut self) -> Result<i64, String> {
        Ok(i64::from_le_bytes(self.bytes()?))
    }

    pub fn f64(&mut self) -> Result<f64, String> {
        Ok(f64::from_le_bytes(self.bytes()?))
    }

    /// A fixed number of float64.
    pub fn f64s<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    pub fn text(&mut self) -> Result<String, String> {
        let length = self.u32()? as usize; // counts the closing NUL
        let begin = self.at;
        self.at += length;
        let found = self.data.get(begin..self.at.max(begin + 1) - 1).ok_or("a message ends too early")?;
        String::from_utf8(found.to_vec()).map_err(|error| error.to_string())
    }

    /// Skips a `std_msgs/Header`: time and frame.
    pub fn header(&mut self) -> Result<(), String> {
        self.u32()?;
        self.u32()?;
        self.text().map(|_| ())
    }
}

/// Writes a message field by field.
#[derive(Default)]
pub struct Writer {
    data: Vec<u8>,
}

impl Writer {
    fn put<const N: usize>(&mut self, bytes: [u8; N]) -> &mut Self {
        self.data.resize(self.data.len().next_multiple_of(N), 0);
        self.data.extend(bytes);
        self
    }

    pub fn u8(&mut self, value: u8) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub fn u32(&mut self, value: u32) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub fn u64(&mut self, value: u64) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub fn i64(&mut self, value: i64) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub fn f64(&mut self, value: f64) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub fn text(&mut self, text: &str) -> &mut Self {
        self.u32(text.len() as u32 + 1);
        self.data.extend(text.as_bytes());
        self.data.push(0);
        self
    }

    /// A `std_msgs/Header` at simulated time `time` [ns].
    pub fn header(&mut self, time: i64, frame: &str) -> &mut Self {
        self.u32((time / 1_000_000_000) as u32).u32((time % 1_000_000_000) as u32).text(frame)
    }

    /// A sequence of uint32.
    pub fn u32_sequence(&mut self, values: impl ExactSizeIterator<Item = u32>) -> &mut Self {
        self.u32(values.len() as u32);
        for value in values {
            self.u32(value);
        }
        self
    }

    /// A sequence of float64.
    pub fn f64_sequence(&mut self, values: &[f64]) -> &mut Self {
        self.u32(values.len() as u32);
        for value in values {
            self.f64(*value);
        }
        self
    }

    pub fn message(&self) -> Vec<u8> {
        [&[0, 1, 0, 0], self.data.as_slice()].concat()
    }
}
