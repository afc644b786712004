"""What every other room uses: files written whole or not at all, caches, threads, wording of messages, ties."""
