"""What this machine has and lacks, for `hmdwarp doctor`."""
