"""What has been seen free: by a scan, by earlier scans, by clouds and by range finders."""
