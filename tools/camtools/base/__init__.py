"""What every command shares: errors of one line, exit states, files that appear whole."""
