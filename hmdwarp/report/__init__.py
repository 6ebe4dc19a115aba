"""What a run leaves behind: summary.json, frames.csv, pictures, a video, one HTML page, and a table in the terminal."""
